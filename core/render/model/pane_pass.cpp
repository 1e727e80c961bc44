#include "core/render/model/pane_pass.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/render/model/gbuffer.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/picture_window.h"
#include "core/render/model/sheet_pass.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr uint32_t kNoPane = UINT32_MAX;
constexpr size_t kPaneGrain = 1024;
constexpr double kOnePane_rel = 1e-5;  // of the distance to the glass: a ray that leaves within it has passed one pane, not two
constexpr double kOwnSurfels = 3;      // in tolerances of a mirror: specular surfels within this distance belong to it
constexpr float kMirrorNear = 1e-3f;   // scene units in front of the mirrored camera; the pane clips, not the camera

}  // namespace

void PaneImages::clear() {
  shown.clear();
  passes_gradient.clear();
  for (auto* plane :
       {&near_color, &far_color, &near_open, &far_open, &far_share, &far_cosine, &grad_near, &grad_open, &picture_weight})
    plane->clear();
}

void PaneImages::start(size_t pixels) {
  shown.assign(pixels, 0);
  for (auto* plane : {&near_color, &far_color}) plane->assign(3 * pixels, 0.f);
  for (auto* plane : {&near_open, &far_open}) plane->assign(pixels, 1.f);
  for (auto* plane : {&far_share, &far_cosine}) plane->assign(pixels, 0.f);
}

// Reflection S = 1 - 2 n n^T at the plane. A camera cannot be reflected (a rotation has determinant 1), so its picture is also
// flipped in x: its rotation is diag(-1, 1, 1) R S.
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

// Finds the surfels of the mirror itself, which would occlude the scene from the mirrored camera.
void PanePass::find_own(const SplatScene& scene, const ShapeSet& set, float min_specular) {
  own_.assign(scene.diffuse.size(), 0);
  for (uint32_t entry = 0; entry < set.entries.size(); ++entry) {
    const ShapeSet::Entry& e = set.entries[entry];
    if (is_glass(e.role) || facets(e.shape).empty()) continue;
    const double reach = kOwnSurfels * e.tolerance;
    const Bounds3 about = bounds(e.shape, reach);
    for (size_t i = 0; i < own_.size(); ++i) {
      const float* m = scene.diffuse.at(Attribute::Mean, i);
      const Vec3d mean{m[0], m[1], m[2]};
      if (!about.contains(mean) || !(sigmoid(*scene.diffuse.at(Attribute::SpecularWeight, i)) > min_specular)) continue;
      if (length(nearest(e.shape, mean).position - mean) <= reach) own_[i] = entry + 1;
    }
  }
}

void PanePass::list_panes(const ShapeSet& set) {
  panes_.clear();
  first_pane_.assign(1, 0);
  for (const ShapeSet::Entry& e : set.entries) {
    for (const Facet& f : facets(e.shape))
      panes_.push_back({f, e.is_clear(panes_.size() - first_pane_.back()), kAtPane_rel * e.tolerance});
    first_pane_.push_back(static_cast<uint32_t>(panes_.size()));
  }
}

// Panes through which the rays of the pixels enter and leave, for rays that pass everything in the case.
void PanePass::find_panes(const Frame& frame, PaneImages& out) {
  const GBuffer g(frame);
  const ShadedPixels& s = frame.shaded;
  const Vec3d eye = frame.view->centre_in_world();
  parallel_chunks(s.pixels.size(), kPaneGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      if (!s.requests[i].transmission) continue;
      const uint32_t pixel = s.pixels[i];
      const Vec3d per_z = cast<double>(g.ray(pixel).direction_per_z);
      if (frame.sheets.entry[pixel] == 0) continue;
      const uint32_t entry = frame.sheets.entry[pixel] - 1;
      if (first_pane_[entry] == first_pane_[entry + 1]) continue;
      pane_of_[Near][pixel] = first_pane_[entry] + frame.sheets.element[pixel];
      out.shown[pixel] = 1;
      if (frame.options.shape.set->entries[entry].role == ShapeRole::Solid) continue;
      // Exit of a convex case: the nearest facet that faces away.
      double leaves_at = 1e300, rise = 0;
      uint32_t by = kNoPane;
      for (uint32_t k = first_pane_[entry]; k < first_pane_[entry + 1]; ++k) {
        const Facet& f = panes_[k].plane;
        const double away = dot(f.normal, per_z), t = (f.offset - dot(f.normal, eye)) / away;
        if (away > 0 && t < leaves_at) leaves_at = t, rise = away, by = k;
      }
      if (by == kNoPane || !panes_[by].clear || leaves_at < (1 + kOnePane_rel) * double(g.zdepth[pixel] / g.alpha[pixel]))
        continue;
      const bool past = (double(frame.behind.median_z[pixel]) - leaves_at) * rise > panes_[by].at_pane;
      if (!past && !(frame.behind.inner_transmittance[pixel] > 0.5f)) continue;
      pane_of_[Far][pixel] = by;
      out.far_share[pixel] = 1;
      out.far_cosine[pixel] = static_cast<float>(rise / length(per_z));
    }
  });
}

// Facets that opaque pixels mirror.
void PanePass::find_mirrors(const Frame& frame, PaneImages& out) {
  const ShapeSet& set = *frame.options.shape.set;
  const std::vector<uint32_t>& shown = frame.silhouette.shapes;
  if (shown.empty()) return;
  const GBuffer g(frame);
  const ShadedPixels& s = frame.shaded;
  const Vec3d eye = frame.view->centre_in_world();
  out.passes_gradient.assign(frame.pixel_count(), 0);
  parallel_chunks(s.pixels.size(), kPaneGrain, [&](size_t, size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const uint32_t pixel = s.pixels[i];
      if (shown[pixel] == 0 || out.shown[pixel] || frame.sheets.shows(pixel)) continue;
      const uint32_t entry = shown[pixel] - 1;
      if (first_pane_[entry] == first_pane_[entry + 1]) continue;
      const auto hit = intersect(set.entries[entry].shape, {eye, cast<double>(g.ray(pixel).direction_per_z)});
      if (!hit) continue;
      pane_of_[Near][pixel] = first_pane_[entry] + hit->element;
      out.shown[pixel] = out.passes_gradient[pixel] = 1;
    }
  });
}

uint32_t PanePass::entry_of(uint32_t pane) const {
  return static_cast<uint32_t>(std::ranges::upper_bound(first_pane_, pane) - first_pane_.begin() - 1);
}

// Renders the reflection in one pane, for all pixels whose rays enter or leave through it.
void PanePass::mirror(const Frame& frame, uint32_t pane, Side side, PaneImages& out) {
  const Facet& plane = panes_[pane].plane;
  const std::vector<uint32_t>& pane_of = pane_of_[side];
  const int width = frame.view->intrinsics.width;
  const size_t pixels = pane_of.size();
  PictureWindow window;  // in the flipped picture
  const auto turned = [&](size_t pixel) { return width - 1 - static_cast<int>(pixel) % width; };
  const auto row_of = [&](size_t pixel) { return static_cast<int>(pixel) / width; };
  for (size_t i = 0; i < pixels; ++i)
    if (pane_of[i] == pane) window.extend(turned(i), row_of(i));
  if (window.empty()) return;
  const uint32_t entry = entry_of(pane);
  const bool passes_gradient = side == Near && !is_glass(frame.options.shape.set->entries[entry].role);
  if (passes_gradient) {
    if (mirrors_.size() == pictures_.size()) pictures_.push_back(std::make_unique<WindowPicture>(backend_));
    mirrors_.push_back({pane, window, {}, pictures_[mirrors_.size()].get()});
  }
  std::vector<uint8_t>& wanted = passes_gradient ? mirrors_.back().wanted : wanted_;
  WindowPicture& drawn = passes_gradient ? *mirrors_.back().picture : window_picture_;
  wanted.assign(window.pixel_count(), 0);
  for (size_t i = 0; i < pixels; ++i)
    if (pane_of[i] == pane) wanted[window.index(turned(i), row_of(i))] = 1;

  // Half-space on the mirror's reflecting side: outside the near pane, inside the far one.
  const double outside = side == Near ? 1 : -1;
  const Vec3f normal = cast<float>(outside * plane.normal);
  const auto offset = static_cast<float>(outside * plane.offset + panes_[pane].at_pane);
  const auto& [opened, opaque] = frame.opened;
  const size_t mirrored = frame.options.panes.mirrored;
  drawn.choose(opened, window.view(mirrored_view(*frame.view, plane.normal, plane.offset)), [&](size_t i) {
    const float* m = opened.at(Attribute::Mean, i);
    return (i >= opaque.size() || (opaque[i] < mirrored && own_[opaque[i]] != entry + 1)) &&
           dot(normal, Vec3f{m[0], m[1], m[2]}) > offset;
  });
  const RasterImages& picture = drawn.draw({.features = FeatureSet::ColorOnly,
                                            .sh_degree = opened.sh_degree(),
                                            .near_z = kMirrorNear,
                                            .wanted = wanted,
                                            .differentiable = passes_gradient});
  const std::span<const float> color = picture.plane(Aov::Color), alpha = picture.plane(Aov::Alpha);
  std::vector<float>& to = side == Near ? out.near_color : out.far_color;
  std::vector<float>& open = side == Near ? out.near_open : out.far_open;
  for (size_t i = 0; i < pixels; ++i) {
    if (pane_of[i] != pane) continue;
    const size_t w = window.index(turned(i), row_of(i));
    for (size_t c = 0; c < 3; ++c) to[c * pixels + i] = color[c * wanted.size() + w];
    open[i] = 1 - alpha[w];
  }
}

void PanePass::forward(const SplatScene& scene, Frame& frame) {
  PaneImages& out = frame.panes;
  out.clear();
  mirrors_.clear();
  if (frame.options.shape.set == nullptr) return;
  list_panes(*frame.options.shape.set);
  if (panes_.empty()) return;
  out.start(frame.pixel_count());
  for (auto& panes : pane_of_) panes.assign(frame.pixel_count(), kNoPane);
  const bool opened =
      draws_sheets(frame.options) || !frame.behind.radiance.empty();  // earlier passes have built the scene without glass
  if (!frame.sheets.empty() && !frame.behind.radiance.empty()) find_panes(frame, out);
  find_mirrors(frame, out);
  if (std::ranges::find(out.shown, 1) == out.shown.end()) return out.clear();
  find_own(scene, *frame.options.shape.set, frame.options.shape.min_specular);
  if (!opened) without_glass(scene, opened_degrees(scene, frame.options), frame.opened);
  for (uint32_t pane = 0; pane < panes_.size(); ++pane)
    for (const Side side : {Near, Far}) mirror(frame, pane, side, out);
  if (!mirrors_.empty()) {
    out.grad_near.assign(3 * frame.pixel_count(), 0.f);
    out.grad_open.assign(frame.pixel_count(), 0.f);
    out.picture_weight.assign(frame.pixel_count(), 0.f);
  }
  // They also reflect before a reflection layer exists.
  ShadedPixels& s = frame.shaded;
  for (size_t i = 0; i < s.pixels.size(); ++i) s.requests[i].reflection |= out.shown[s.pixels[i]] != 0;
}

// A flat mirror of known position acts as one more camera.
void PanePass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  if (mirrors_.empty()) return;
  const PaneImages& panes = frame.panes;
  const SplatLayer& opened = frame.opened.surfels;
  if (grad_.kind() != opened.kind() || grad_.size() != opened.size() || grad_.sh_degree() != opened.sh_degree())
    grad_ = opened.zeros_like();
  else
    grad_.fill(0.f);
  statistics_.reset(opened.size());
  const int width = frame.view->intrinsics.width;
  const size_t pixels = frame.pixel_count();
  std::vector<float> error_image;
  for (const MirrorPicture& m : mirrors_) {
    const size_t size = m.wanted.size();
    const std::span<float> color = m.picture->gradients().plane(Aov::Color), alpha = m.picture->gradients().plane(Aov::Alpha);
    error_image.assign(frame.error_image.empty() ? 0 : size, 0.f);
    for (size_t i = 0; i < pixels; ++i) {
      if (pane_of_[Near][i] != m.pane) continue;
      const size_t w = m.window.index(width - 1 - static_cast<int>(i) % width, static_cast<int>(i) / width);
      for (size_t c = 0; c < 3; ++c) color[c * size + w] = panes.grad_near[c * pixels + i];
      alpha[w] = -panes.grad_open[i];
      if (!error_image.empty()) error_image[w] = panes.picture_weight[i] * frame.error_image[i];
    }
    m.picture->backward(error_image, grad_, statistics_);
  }
  give_back(opened_degrees(scene, frame.options), {grad_, statistics_}, frame, grad);
}

}  // namespace vitrine
