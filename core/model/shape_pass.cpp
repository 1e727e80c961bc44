#include "core/model/shape_pass.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/gbuffer.h"
#include "core/model/kernels/turned_point.h"

namespace vitrine {

namespace {

constexpr double kOnSolid_rel = 0.06;  // of its largest radius: surfels that show it lie this near, spouts and handles do not
constexpr double kBehind_rel = 0.5;    // and not so far behind it: another thing, seen where the solid is gone
constexpr size_t kRows = 8;

TurnedLine<double> line_of(const TurnedSurface& s, const std::vector<Vec2d>& normals, size_t line) {
  return {s.origin, s.axis, s.profile[line], s.profile[line + 1], normals[line], normals[line + 1]};
}

void add(Vec2d& to, const Vec2d& v) { to.x += v.x, to.y += v.y; }

}  // namespace

void ShapePass::forward(const SplatScene& scene, Frame& frame) {
  bands_.clear();
  if (!options_.shapes || options_.shapes->empty() || scene.reflection.size() == 0) return;
  const std::vector<TurnedSurface>& shapes = *options_.shapes;
  std::vector<std::vector<Vec2d>> normals;
  std::vector<double> radius;
  for (const TurnedSurface& s : shapes) normals.push_back(s.corner_normals()), radius.push_back(s.largest_radius());
  const GBuffer g(frame);
  const auto width = static_cast<size_t>(g.width);
  const Vec3d eye = frame.view->centre_in_world();
  const std::span<float> normal = frame.diffuse.plane(Aov::Normal), zdepth = frame.diffuse.plane(Aov::ZDepth);
  bands_.resize((static_cast<size_t>(g.height) + kRows - 1) / kRows);
  parallel_for(bands_.size(), 1, [&](size_t band) {
    const size_t end = std::min((band + 1) * kRows * width, g.pixels);
    for (size_t i = band * kRows * width; i < end; ++i) {
      const auto pixel = static_cast<uint32_t>(i);
      const float alpha = g.alpha[pixel];
      if (!(alpha > options_.min_alpha) || !(g.specular[pixel] > options_.polished * alpha)) continue;
      const Vec3d per_z = cast<double>(g.ray(pixel).direction_per_z);
      const double z = double(g.zdepth[pixel]) / double(alpha);
      for (size_t k = 0; k < shapes.size(); ++k) {
        const auto entry = shapes[k].entry(eye, per_z);
        if (!entry) continue;
        const double in_front = (entry->t - z) * length(per_z) / radius[k];
        if (in_front > kOnSolid_rel || in_front < -kBehind_rel) continue;
        const TurnedPoint<double> point = turned_point(line_of(shapes[k], normals[k], entry->line), eye, per_z, entry->t);
        if (!(dot(point.normal, per_z) < 0)) continue;
        const Shaped shaped{pixel, static_cast<uint32_t>(k), static_cast<uint32_t>(entry->line), static_cast<float>(point.t),
                            cast<float>(point.normal)};
        for (size_t c = 0; c < 3; ++c) normal[c * g.pixels + pixel] = alpha * shaped.normal[c];
        zdepth[pixel] = alpha * shaped.t;
        bands_[band].push_back(shaped);
        break;
      }
    }
  });
}

// Of the pixels that sent rays; what losses on normals and depths want is meant for the surfels.
void ShapePass::shape_gradients(const Frame& frame) {
  const std::vector<TurnedSurface>& shapes = *options_.shapes;
  std::vector<std::vector<Vec2d>> normals;
  for (const TurnedSurface& s : shapes) normals.push_back(s.corner_normals());
  const auto nothing = [&] {
    std::vector<TurnedGradient> out(shapes.size());
    for (size_t k = 0; k < shapes.size(); ++k) out[k].profile.resize(shapes[k].profile.size());
    return out;
  };
  gradients_ = nothing();
  std::vector<TurnedGradient> on_normals = nothing();  // at the corners
  const ShadedPixels& s = frame.shaded;
  std::vector<uint32_t> group_of(frame.pixel_count(), UINT32_MAX);
  for (size_t g = 0; g < s.groups(); ++g) group_of[s.chosen_pixel(g)] = static_cast<uint32_t>(g);
  const Vec3d eye = frame.view->centre_in_world();
  for (const auto& band : bands_)
    for (const Shaped& at : band) {
      const uint32_t group = group_of[at.pixel];
      if (group == UINT32_MAX) continue;
      const SurfacePoint<float>& grad = s.grad_points[group];
      const Vec3f on_normal = grad.normal + grad.cosine * s.rays[group].view;
      const Vec3d per_z = cast<double>(s.rays[group].direction_per_z), on_point = cast<double>(grad.position);
      const TurnedLine<double> back =
          turned_point_vjp(line_of(shapes[at.shape], normals[at.shape], at.line), eye, per_z, double(at.t),
                           TurnedPoint<double>{dot(on_point, per_z), cast<double>(on_normal)});
      TurnedGradient& out = gradients_[at.shape];
      out.origin += back.origin;
      out.axis += back.axis;
      add(out.profile[at.line], back.p0);
      add(out.profile[at.line + 1], back.p1);
      add(on_normals[at.shape].profile[at.line], back.n0);
      add(on_normals[at.shape].profile[at.line + 1], back.n1);
    }
  for (size_t k = 0; k < shapes.size(); ++k) corner_normals_vjp(shapes[k], on_normals[k].profile, gradients_[k].profile);
}

// N = A n and Z = A z, n and z of the solid.
void ShapePass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  gradients_.clear();
  if (bands_.empty()) return;
  shape_gradients(frame);
  const size_t pixels = frame.pixel_count();
  RasterImages& grad = frame.grad_diffuse;
  const std::span<float> normal = grad.plane(Aov::Normal), zdepth = grad.plane(Aov::ZDepth), alpha = grad.plane(Aov::Alpha);
  for (const auto& band : bands_)
    for (const Shaped& s : band) {
      float sum = s.t * zdepth[s.pixel];
      zdepth[s.pixel] = 0;
      for (size_t c = 0; c < 3; ++c) {
        sum += s.normal[c] * normal[c * pixels + s.pixel];
        normal[c * pixels + s.pixel] = 0;
      }
      alpha[s.pixel] += sum;
    }
}

}  // namespace vitrine
