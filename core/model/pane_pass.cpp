#include "core/model/pane_pass.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/gbuffer.h"

namespace vitrine {

namespace {

constexpr uint8_t kNoFace = 255;
constexpr size_t kPaneGrain = 1024;
// Of the longest side of the box: the picture shows the box where its surface lies this near to it; what stands this near to a
// pane is the pane's frame or its floor, and not seen in it.
constexpr double kOnBox_rel = 0.05, kAtPane_rel = 0.02;
constexpr float kMirrorNear = 1e-3f;  // scene units before the camera behind the mirror; the pane cuts, not the camera

}  // namespace

void PaneImages::clear() {
  shown.clear();
  for (auto* plane : {&near_color, &far_color, &near_open, &far_open, &far_share, &far_cosine}) plane->clear();
}

void PaneImages::start(size_t pixels) {
  shown.assign(pixels, 0);
  for (auto* plane : {&near_color, &far_color}) plane->assign(3 * pixels, 0.f);
  for (auto* plane : {&near_open, &far_open}) plane->assign(pixels, 1.f);
  for (auto* plane : {&far_share, &far_cosine}) plane->assign(pixels, 0.f);
}

// Behind the plane everything is mirrored, S = 1 - 2 n n^T. A camera cannot be, so it sees the mirrored room mirrored once more,
// in x: its rotation is diag(-1, 1, 1) R S.
View mirrored_view(const View& view, const Vec3d& normal, double offset) {
  View out = view;
  Mat3d& rotation = out.cam_from_world.rotation;
  const Vec3d in_camera = rotation * normal, eye = view.centre_in_world();
  for (size_t i = 0; i < 3; ++i) {
    rotation.column(i) += -2 * normal[i] * in_camera;
    rotation(0, i) = -rotation(0, i);
  }
  out.cam_from_world.translation = -(rotation * (eye - 2 * (dot(eye, normal) - offset) * normal));
  out.intrinsics.cx = view.intrinsics.width - view.intrinsics.cx;
  return out;
}

// By which panes the rays of the pixels enter and leave, those that get past everything in the case.
void PanePass::find_panes(const Frame& frame, PaneImages& out) {
  const OrientedBox& box = options_.glass_case->box;
  const double on_box = kOnBox_rel * box.longest_side(), at_pane = kAtPane_rel * box.longest_side();
  const GBuffer g(frame);
  const ShadedPixels& s = frame.shaded;
  for (auto& faces : face_of_) faces.assign(g.pixels, kNoFace);
  const Vec3d eye = frame.view->centre_in_world();
  parallel_chunks(s.pixels.size(), kPaneGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      if (!s.asks[i].transmission) continue;
      const uint32_t pixel = s.pixels[i];
      const Vec3d per_z = cast<double>(g.ray(pixel).direction_per_z);
      const auto crossing = box.crossing(eye, per_z);
      if (!crossing) continue;
      const double z = double(g.zdepth[pixel]) / double(g.alpha[pixel]);
      if (std::abs(box.distance(eye + z * per_z)) > on_box) continue;
      face_of_[Near][pixel] = static_cast<uint8_t>(crossing->entered.index());
      out.shown[pixel] = 1;
      if (!options_.glass_case->clear[crossing->left.index()]) continue;
      const double rise = dot(box.normal(crossing->left), per_z);
      const bool past = (double(frame.behind.median_z[pixel]) - crossing->out) * rise > at_pane;
      if (!past && !(frame.behind.inner_transmittance[pixel] > 0.5f)) continue;
      face_of_[Far][pixel] = static_cast<uint8_t>(crossing->left.index());
      out.far_share[pixel] = 1;
      out.far_cosine[pixel] = static_cast<float>(rise / length(per_z));
    }
  });
}

// The picture in one pane, of all pixels whose rays enter or leave by it.
void PanePass::mirror(const View& view, OrientedBox::Face face, Pane pane, PaneImages& out) {
  const OrientedBox& box = options_.glass_case->box;
  const std::vector<uint8_t>& face_of = face_of_[pane];
  const auto index = static_cast<uint8_t>(face.index());
  const auto width = static_cast<size_t>(view.intrinsics.width);
  const auto turned = [&](size_t pixel) { return pixel + width - 1 - 2 * (pixel % width); };
  if (std::ranges::find(face_of, index) == face_of.end()) return;
  wanted_.resize(face_of.size());
  for (size_t i = 0; i < face_of.size(); ++i) wanted_[turned(i)] = face_of[i] == index;

  // What lies on the mirror's own side: outside of the near pane, inside of the far one.
  const double side = pane == Near ? 1 : -1;
  const Vec3f normal = cast<float>(side * box.normal(face));
  const auto offset = static_cast<float>(side * box.offset(face) + kAtPane_rel * box.longest_side());
  const SplatLayer& merged = behind_.merged();
  const std::span<const uint32_t> opaque = behind_.opaque();
  std::vector<uint32_t> kept;
  for (size_t i = 0; i < merged.size(); ++i) {
    if (i < opaque.size() && opaque[i] >= options_.mirrored) continue;
    const float* m = merged.at(Attribute::Mean, i);
    if (dot(normal, Vec3f{m[0], m[1], m[2]}) > offset) kept.push_back(static_cast<uint32_t>(i));
  }
  if (beside_.kind() != merged.kind() || beside_.sh_degree() != merged.sh_degree())
    beside_ = SplatLayer(merged.kind(), merged.sh_degree(), 0);
  beside_.resize(kept.size());
  parallel_chunks(kept.size(), kPaneGrain, [&](size_t, size_t first, size_t last) {
    for (const AttributeRow& r : kAttributes)
      for (size_t k = first; k < last; ++k) std::copy_n(merged.at(r.id, kept[k]), merged.width(r.id), beside_.at(r.id, k));
  });

  const View mirrored = mirrored_view(view, box.normal(face), box.offset(face));
  RasterDesc desc;
  desc.intrinsics = mirrored.intrinsics;
  desc.cam_from_world = mirrored.cam_from_world;
  desc.features = FeatureSet::ColorOnly;
  desc.near_z = kMirrorNear;
  desc.sh_degree = beside_.sh_degree();
  desc.wanted = wanted_;
  renderer_->forward(beside_, desc, picture_);
  const std::span<const float> color = picture_.plane(Aov::Color), alpha = picture_.plane(Aov::Alpha);
  std::vector<float>& to = pane == Near ? out.near_color : out.far_color;
  std::vector<float>& open = pane == Near ? out.near_open : out.far_open;
  const size_t pixels = face_of.size();
  for (size_t i = 0; i < pixels; ++i) {
    if (face_of[i] != index) continue;
    const size_t from = turned(i);
    for (size_t c = 0; c < 3; ++c) to[c * pixels + i] = color[c * pixels + from];
    open[i] = 1 - alpha[from];
  }
}

void PanePass::forward(const SplatScene&, Frame& frame) {
  PaneImages& out = frame.panes;
  out.clear();
  if (!options_.glass_case || frame.behind.radiance.empty()) return;
  out.start(frame.pixel_count());
  find_panes(frame, out);
  if (std::ranges::find(out.shown, 1) == out.shown.end()) return out.clear();
  for (size_t f = 0; f < OrientedBox::kFaces; ++f)
    for (const Pane pane : {Near, Far}) mirror(*frame.view, OrientedBox::face(f), pane, out);
  // They mirror before there is a reflection layer, too.
  ShadedPixels& s = frame.shaded;
  for (size_t i = 0; i < s.pixels.size(); ++i) s.asks[i].reflection |= out.shown[s.pixels[i]] != 0;
}

}  // namespace vitrine
