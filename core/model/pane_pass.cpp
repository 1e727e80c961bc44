#include "core/model/pane_pass.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/gbuffer.h"
#include "core/model/thin_glass_pass.h"

namespace vitrine {

namespace {

constexpr uint8_t kNoFace = 255;
constexpr Attribute kShapeAndColor[] = {Attribute::Mean,    Attribute::Rotation, Attribute::LogScale,
                                        Attribute::Opacity, Attribute::ShDc,     Attribute::ShRest};
// Of the longest side of the box: the picture shows the box where its surface lies this near to it; what stands this near to a
// pane is the pane's frame or its floor, and not seen in it.
constexpr double kOnBox_rel = 0.05, kAtPane_rel = 0.02;
constexpr float kMirrorNear = 1e-3f;  // scene units before the camera behind the mirror; the pane cuts, not the camera

}  // namespace

void PaneImages::clear() {
  shown.clear();
  for (auto* plane : {&near_color, &far_color, &near_open, &far_open, &far_z, &far_cosine, &far_rise}) plane->clear();
}

void PaneImages::start(size_t pixels) {
  shown.assign(pixels, 0);
  for (auto* plane : {&near_color, &far_color}) plane->assign(3 * pixels, 0.f);
  for (auto* plane : {&near_open, &far_open}) plane->assign(pixels, 1.f);
  for (auto* plane : {&far_z, &far_cosine, &far_rise}) plane->assign(pixels, 0.f);
}

// Behind the plane everything is mirrored, S = 1 - 2 n n^T. A camera cannot be, so it sees the mirrored room mirrored once more,
// in x.
View mirrored_view(const View& view, const Vec3d& normal, double offset) {
  View out = view;
  const Mat3d& r = view.cam_from_world.rotation;
  const auto in_mirror = [&](const Vec3d& v) { return v - 2 * dot(v, normal) * normal; };
  const auto row = [&](size_t i) {
    return in_mirror(transposed_times(r, Vec3d{i == 0 ? 1.0 : 0, i == 1 ? 1.0 : 0, i == 2 ? 1.0 : 0}));
  };
  const Vec3d x = -row(0), y = row(1), z = row(2);
  out.cam_from_world.rotation = {{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
  const Vec3d eye = in_mirror(view.centre_in_world()) + 2 * offset * normal;
  out.cam_from_world.translation = -(out.cam_from_world.rotation * eye);
  out.intrinsics.cx = view.intrinsics.width - view.intrinsics.cx;
  return out;
}

// By which panes the rays of the pixels enter and leave.
void PanePass::find_panes(const Frame& frame, PaneImages& out) {
  const OrientedBox& box = options_.glass_case->box;
  const GBuffer g(frame);
  const ShadedPixels& s = frame.shaded;
  near_face_.assign(g.pixels, kNoFace);
  far_face_.assign(g.pixels, kNoFace);
  const Vec3d eye = frame.view->centre_in_world();
  const double near = kOnBox_rel * box.longest_side();
  parallel_chunks(s.pixels.size(), 1024, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      if (!s.asks[i].transmission) continue;
      const uint32_t pixel = s.pixels[i];
      const Vec3d per_z = cast<double>(g.ray(pixel).direction_per_z);
      const auto crossing = box.crossing(eye, per_z);
      if (!crossing) continue;
      const double z = double(g.zdepth[pixel]) / double(g.alpha[pixel]);
      if (std::abs(box.distance(eye + z * per_z)) > near) continue;
      near_face_[pixel] = static_cast<uint8_t>(crossing->entered.index());
      if (!options_.glass_case->clear[crossing->left.index()]) continue;
      const double rise = dot(box.normal(crossing->left), per_z);
      far_face_[pixel] = static_cast<uint8_t>(crossing->left.index());
      out.far_z[pixel] = static_cast<float>(crossing->out);
      out.far_rise[pixel] = static_cast<float>(rise);
      out.far_cosine[pixel] = static_cast<float>(rise / length(per_z));
    }
  });
}

// The picture in one pane, of all pixels whose rays enter (`far`: leave) by it.
void PanePass::mirror(const Frame& frame, OrientedBox::Face face, bool far, PaneImages& out) {
  const OrientedBox& box = options_.glass_case->box;
  const std::vector<uint8_t>& face_of = far ? far_face_ : near_face_;
  const auto index = static_cast<uint8_t>(face.index());
  const auto width = static_cast<size_t>(frame.view->intrinsics.width),
             height = static_cast<size_t>(frame.view->intrinsics.height);
  const size_t pixels = width * height;
  const auto turned = [&](size_t pixel) { return pixel - pixel % width + (width - 1 - pixel % width); };
  wanted_.assign(pixels, 0);
  bool any = false;
  for (size_t i = 0; i < pixels; ++i)
    if (face_of[i] == index) wanted_[turned(i)] = 1, any = true;
  if (!any) return;
  // The mirror's own side: outside of the near pane, inside of the far one.
  const Vec3f normal = cast<float>((far ? -1.0 : 1.0) * box.normal(face));
  const float offset = static_cast<float>((far ? -1.0 : 1.0) * box.offset(face) + kAtPane_rel * box.longest_side());
  std::vector<uint32_t> kept;
  for (size_t i = 0; i < merged_.size(); ++i) {
    if (i < opaque_.size() && opaque_[i] >= options_.mirrored) continue;
    const float* m = merged_.at(Attribute::Mean, i);
    if (dot(normal, Vec3f{m[0], m[1], m[2]}) > offset) kept.push_back(static_cast<uint32_t>(i));
  }
  if (beside_.kind() != merged_.kind() || beside_.sh_degree() != merged_.sh_degree())
    beside_ = SplatLayer(merged_.kind(), merged_.sh_degree(), 0);
  beside_.resize(kept.size());
  parallel_chunks(kept.size(), 4096, [&](size_t, size_t first, size_t last) {
    for (Attribute a : kShapeAndColor)
      for (size_t k = first; k < last; ++k) std::copy_n(merged_.at(a, kept[k]), merged_.width(a), beside_.at(a, k));
  });
  const View behind = mirrored_view(*frame.view, box.normal(face), box.offset(face));
  RasterDesc desc;
  desc.intrinsics = behind.intrinsics;
  desc.cam_from_world = behind.cam_from_world;
  desc.features = FeatureSet::ColorOnly;
  desc.near_z = kMirrorNear;
  desc.sh_degree = beside_.sh_degree();
  desc.wanted = wanted_;
  renderer_->forward(beside_, desc, picture_);
  const std::span<const float> color = picture_.plane(Aov::Color), alpha = picture_.plane(Aov::Alpha);
  std::vector<float>& to = far ? out.far_color : out.near_color;
  std::vector<float>& open = far ? out.far_open : out.near_open;
  for (size_t i = 0; i < pixels; ++i) {
    if (face_of[i] != index) continue;
    const size_t from = turned(i);
    for (size_t c = 0; c < 3; ++c) to[c * pixels + i] = color[c * pixels + from];
    open[i] = 1 - alpha[from];
  }
}

void PanePass::forward(const SplatScene& scene, Frame& frame) {
  PaneImages& out = frame.panes;
  out.clear();
  if (!options_.glass_case || scene.transmittance.size() == 0 || frame.shaded.groups() == 0) return;
  out.start(frame.pixel_count());
  out.at_pane = static_cast<float>(kAtPane_rel * options_.glass_case->box.longest_side());
  find_panes(frame, out);
  if (std::ranges::all_of(near_face_, [](uint8_t f) { return f == kNoFace; })) return out.clear();
  without_glass(scene, diffuse_.sh_degree, transmission_.sh_degree, opaque_, merged_);
  for (size_t f = 0; f < OrientedBox::kFaces; ++f) {
    mirror(frame, OrientedBox::face(f), false, out);
    mirror(frame, OrientedBox::face(f), true, out);
  }
  for (size_t i = 0; i < frame.pixel_count(); ++i) out.shown[i] = near_face_[i] != kNoFace;
  ShadedPixels& s = frame.shaded;
  for (size_t i = 0; i < s.pixels.size(); ++i) s.asks[i].reflection |= out.shown[s.pixels[i]] != 0;
}

}  // namespace vitrine
