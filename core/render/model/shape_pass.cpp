#include "core/render/model/shape_pass.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"
#include "core/render/model/gbuffer.h"

namespace vitrine {

namespace {

// Maximum distance of a pixel's surface behind a shape, in tolerances: its far side, seen through gaps of the near side. A
// surface farther behind is another object, seen where the shape is missing.
constexpr double kBehind = 2.2 / 0.06;
// The same for a coat: paint has no gaps, but a visual hull fills concavities.
constexpr double kBehindCoat = 4;
constexpr size_t kBandRows = 8;

// Bounds of the surfels of coats.
std::vector<Bounds3> coat_bounds(const ShapeSet& set) {
  std::vector<Bounds3> out;
  for (const ShapeSet::Entry& e : set.entries) {
    if (e.role != ShapeRole::Coat) continue;
    out.push_back(bounds(e.shape, kBehindCoat * e.tolerance));
  }
  return out;
}

}  // namespace

std::optional<ShapeSet::Hit> shown_mirror(const ShapeSet& set, const Ray& ray, double z) {
  const double speed = length(ray.direction);
  return set.first_hit(ray, ShapeRole::Mirror, [&](const ShapeSet::Hit& h) {
    const double in_front = (h.t - z) * speed, tolerance = set.entries[h.entry].tolerance;
    return in_front <= tolerance && in_front >= -kBehind * tolerance && dot(h.normal, ray.direction) < 0;
  });
}

void CoatImages::clear() { entry.clear(), normal.clear(), z.clear(); }

void CoatImages::start(size_t pixels) {
  entry.assign(pixels, 0);
  normal.assign(3 * pixels, 0.f);
  z.assign(pixels, 0.f);
}

void ShapePass::forward(const SplatScene& scene, Frame& frame) {
  options_ = frame.options.shape;
  bands_.clear();
  frame.silhouette.shapes.clear();
  frame.coats.clear();
  if (scene.reflection.size() == 0) return;
  if (knows(options_.set.get(), ShapeRole::Mirror)) show_mirrors(frame);
  if (knows(options_.set.get(), ShapeRole::Coat)) show_coats(frame);
}

void ShapePass::show_mirrors(Frame& frame) {
  const ShapeSet& set = *options_.set;
  const GBuffer g(frame);
  const auto width = static_cast<size_t>(g.width);
  const Vec3d eye = frame.view->centre_in_world();
  const std::span<float> normal = frame.diffuse.plane(Aov::Normal), zdepth = frame.diffuse.plane(Aov::ZDepth);
  frame.silhouette.shapes.assign(g.pixels, 0);
  bands_.resize((static_cast<size_t>(g.height) + kBandRows - 1) / kBandRows);
  parallel_for(bands_.size(), 1, [&](size_t band) {
    const size_t end = std::min((band + 1) * kBandRows * width, g.pixels);
    for (size_t i = band * kBandRows * width; i < end; ++i) {
      const auto pixel = static_cast<uint32_t>(i);
      const float alpha = g.alpha[pixel];
      if (!(alpha > options_.min_alpha) || !(g.specular[pixel] > options_.min_specular * alpha)) continue;
      const Vec3d per_z = cast<double>(g.ray(pixel).direction_per_z);
      const auto hit = shown_mirror(set, {eye, per_z}, double(g.zdepth[pixel]) / double(alpha));
      if (!hit) continue;
      for (size_t c = 0; c < 3; ++c) normal[c * g.pixels + pixel] = alpha * static_cast<float>(hit->normal[c]);
      zdepth[pixel] = alpha * static_cast<float>(hit->t);
      frame.silhouette.shapes[pixel] = hit->entry + 1;
      bands_[band].push_back({pixel, *hit});
    }
  });
}

void ShapePass::show_coats(Frame& frame) const {
  const ShapeSet& set = *options_.set;
  const std::vector<Bounds3> reach = coat_bounds(set);
  const GBuffer g(frame);
  const auto width = static_cast<size_t>(g.width);
  const Vec3d eye = frame.view->centre_in_world();
  CoatImages& coats = frame.coats;
  coats.start(g.pixels);
  parallel_for(static_cast<size_t>(g.height), kBandRows, [&](size_t row) {
    for (size_t i = row * width; i < (row + 1) * width; ++i) {
      const auto pixel = static_cast<uint32_t>(i);
      const float alpha = g.alpha[pixel];
      if (!(alpha > options_.min_alpha) || (!frame.silhouette.shapes.empty() && frame.silhouette.shapes[pixel] != 0)) continue;
      const Vec3d per_z = cast<double>(g.ray(pixel).direction_per_z);
      const double z = double(g.zdepth[pixel]) / double(alpha), speed = length(per_z);
      const Vec3d place = eye + z * per_z;
      if (std::ranges::none_of(reach, [&](const Bounds3& b) { return b.contains(place); })) continue;
      const auto hit = set.first_hit({eye, per_z}, ShapeRole::Coat, [&](const ShapeSet::Hit& h) {
        const double in_front = (h.t - z) * speed, tolerance = set.entries[h.entry].tolerance;
        return in_front <= tolerance && in_front >= -kBehindCoat * tolerance && dot(h.normal, per_z) < 0;
      });
      if (!hit) continue;
      coats.entry[pixel] = hit->entry + 1;
      if (!set.entries[hit->entry].exact) continue;
      for (size_t c = 0; c < 3; ++c) coats.normal[c * g.pixels + pixel] = static_cast<float>(hit->normal[c]);
      coats.z[pixel] = static_cast<float>(hit->t);
    }
  });
}

// Uses the pixels that sent rays; pixels crossed by a silhouette contribute only through the silhouette, since their centre was
// not the reflection point (SilhouettePass). Gradients of losses on normals and depths go to the surfels.
void ShapePass::shape_gradients(const Frame& frame) {
  const ShapeSet& set = *options_.set;
  for (const ShapeSet::Entry& e : set.entries) gradients_.emplace_back(parameter_count(e.shape), 0.0);
  const ShadedPixels& s = frame.shaded;
  std::vector<uint32_t> group_of(frame.pixel_count(), UINT32_MAX);
  for (size_t g = 0; g < s.groups(); ++g) group_of[s.chosen_pixel(g)] = static_cast<uint32_t>(g);
  for (const SilhouettePixel& p : frame.silhouette.pixels)
    if (p.crossed) group_of[p.pixel] = UINT32_MAX;
  const Vec3d eye = frame.view->centre_in_world();
  for (const auto& band : bands_)
    for (const auto& [pixel, hit] : band) {
      const uint32_t group = group_of[pixel];
      if (group == UINT32_MAX) continue;
      const SurfacePoint<float>& grad = s.grad_points[group];
      const Vec3f on_normal = grad.normal + grad.cosine * s.rays[group].view;
      const Vec3d per_z = cast<double>(s.rays[group].direction_per_z);
      hit_vjp(set.entries[hit.entry].shape, {eye, per_z}, hit, {dot(cast<double>(grad.position), per_z), cast<double>(on_normal)},
              gradients_[hit.entry]);
    }
  const SilhouetteImages& silhouette = frame.silhouette;
  for (size_t i = 0; i < silhouette.grad_covered.size(); ++i)
    if (const SilhouettePixel& p = silhouette.pixels[i]; silhouette.grad_covered[i] != 0)
      silhouette_vjp(p, set.entries[p.entry].shape, double(silhouette.grad_covered[i]), gradients_[p.entry]);
}

// N = A n and Z = A z, with n and z of the shape.
void ShapePass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  gradients_.clear();
  if (bands_.empty()) return;
  shape_gradients(frame);
  const size_t pixels = frame.pixel_count();
  RasterImages& grad = frame.grad_diffuse;
  const std::span<float> normal = grad.plane(Aov::Normal), zdepth = grad.plane(Aov::ZDepth), alpha = grad.plane(Aov::Alpha);
  for (const auto& band : bands_)
    for (const auto& [pixel, hit] : band) {
      float sum = static_cast<float>(hit.t) * zdepth[pixel];
      zdepth[pixel] = 0;
      for (size_t c = 0; c < 3; ++c) {
        sum += static_cast<float>(hit.normal[c]) * normal[c * pixels + pixel];
        normal[c * pixels + pixel] = 0;
      }
      alpha[pixel] += sum;
    }
}

}  // namespace vitrine
