#include "core/model/pane_pass.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/gbuffer.h"
#include "core/model/picture_window.h"

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
  const GlassCase& glass_case = *frame.options.panes.glass_case;
  const Box& box = glass_case.box;
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
      if (!glass_case.clear[crossing->left.index()]) continue;
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
void PanePass::mirror(const Frame& frame, Box::Face face, Pane pane, PaneImages& out) {
  const Box& box = frame.options.panes.glass_case->box;
  const std::vector<uint8_t>& face_of = face_of_[pane];
  const auto index = static_cast<uint8_t>(face.index());
  const int width = frame.view->intrinsics.width;
  const size_t pixels = face_of.size();
  PictureWindow window;  // of the picture turned left to right
  const auto turned = [&](size_t pixel) { return width - 1 - static_cast<int>(pixel) % width; };
  const auto row_of = [&](size_t pixel) { return static_cast<int>(pixel) / width; };
  for (size_t i = 0; i < pixels; ++i)
    if (face_of[i] == index) window.extend(turned(i), row_of(i));
  if (window.empty()) return;
  wanted_.assign(window.pixel_count(), 0);
  for (size_t i = 0; i < pixels; ++i)
    if (face_of[i] == index) wanted_[window.index(turned(i), row_of(i))] = 1;

  // What lies on the mirror's own side: outside of the near pane, inside of the far one.
  const double side = pane == Near ? 1 : -1;
  const Vec3f normal = cast<float>(side * box.normal(face));
  const auto offset = static_cast<float>(side * box.offset(face) + kAtPane_rel * box.longest_side());
  const auto& [opened, opaque] = frame.opened;
  const size_t mirrored = frame.options.panes.mirrored;
  window_picture_.choose(opened, window.view(mirrored_view(*frame.view, box.normal(face), box.offset(face))), [&](size_t i) {
    const float* m = opened.at(Attribute::Mean, i);
    return (i >= opaque.size() || opaque[i] < mirrored) && dot(normal, Vec3f{m[0], m[1], m[2]}) > offset;
  });
  const RasterImages& picture = window_picture_.draw(
      {.features = FeatureSet::ColorOnly, .sh_degree = opened.sh_degree(), .near_z = kMirrorNear, .wanted = wanted_});
  const std::span<const float> color = picture.plane(Aov::Color), alpha = picture.plane(Aov::Alpha);
  std::vector<float>& to = pane == Near ? out.near_color : out.far_color;
  std::vector<float>& open = pane == Near ? out.near_open : out.far_open;
  for (size_t i = 0; i < pixels; ++i) {
    if (face_of[i] != index) continue;
    const size_t w = window.index(turned(i), row_of(i));
    for (size_t c = 0; c < 3; ++c) to[c * pixels + i] = color[c * wanted_.size() + w];
    open[i] = 1 - alpha[w];
  }
}

void PanePass::forward(const SplatScene&, Frame& frame) {
  PaneImages& out = frame.panes;
  out.clear();
  if (!frame.options.panes.glass_case || frame.behind.radiance.empty()) return;
  out.start(frame.pixel_count());
  find_panes(frame, out);
  if (std::ranges::find(out.shown, 1) == out.shown.end()) return out.clear();
  for (size_t f = 0; f < Box::kFaces; ++f)
    for (const Pane pane : {Near, Far}) mirror(frame, Box::face(f), pane, out);
  // They mirror before there is a reflection layer, too.
  ShadedPixels& s = frame.shaded;
  for (size_t i = 0; i < s.pixels.size(); ++i) s.asks[i].reflection |= out.shown[s.pixels[i]] != 0;
}

}  // namespace vitrine
