#include "core/model/shape_pass.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/model/gbuffer.h"
#include "core/model/shape_mesh.h"
#include "core/shape/shape.h"

namespace vitrine {

namespace {

constexpr double kOnSolid_rel = 0.06;  // of its largest radius: surfels that show it lie this near, appendages do not
// And not so far behind it: another thing, seen where the solid is gone. Gaps of its near side show its far side.
constexpr double kBehind_rel = 2.2;
constexpr size_t kRows = 8;
constexpr uint32_t kBeside = UINT32_MAX;  // Shaped::shape of the mesh
constexpr float kFarBehind = 40;          // tolerances of the mesh, for the same
constexpr double kGrazing = 0.05;         // cosine to the ray: where it is less, the place along the ray says nothing of the mesh
// Cosine of normals, and height above the solid in tolerances: there the mesh is the solid, which knows better.
constexpr float kSameSurface = 0.9f, kSameHeight = 0.5f;

}  // namespace

void ShapePass::forward(const SplatScene& scene, Frame& frame) {
  options_ = frame.options.shape;
  bands_.clear();
  frame.outline.shapes.clear();
  if (!options_.shapes || options_.shapes->empty() || scene.reflection.size() == 0) return;
  const std::vector<SurfaceOfRevolution>& shapes = *options_.shapes;
  std::vector<double> radius;
  for (const SurfaceOfRevolution& s : shapes) radius.push_back(s.largest_radius());
  const GBuffer g(frame);
  const auto width = static_cast<size_t>(g.width);
  const Vec3d eye = frame.view->centre_in_world();
  const std::span<float> normal = frame.diffuse.plane(Aov::Normal), zdepth = frame.diffuse.plane(Aov::ZDepth);
  frame.outline.shapes.assign(g.pixels, 0);
  bands_.resize((static_cast<size_t>(g.height) + kRows - 1) / kRows);
  parallel_for(bands_.size(), 1, [&](size_t band) {
    const size_t end = std::min((band + 1) * kRows * width, g.pixels);
    for (size_t i = band * kRows * width; i < end; ++i) {
      const auto pixel = static_cast<uint32_t>(i);
      const float alpha = g.alpha[pixel];
      if (!(alpha > options_.min_alpha) || !(g.specular[pixel] > options_.polished * alpha)) continue;
      const Vec3d per_z = cast<double>(g.ray(pixel).direction_per_z);
      const double z = double(g.zdepth[pixel]) / double(alpha);
      std::optional<Shaped> shown;
      for (size_t k = 0; k < shapes.size(); ++k) {
        const auto entry = shapes[k].intersect({eye, per_z});
        if (!entry) continue;
        const double in_front = (entry->t - z) * length(per_z) / radius[k];
        if (in_front > kOnSolid_rel || in_front < -kBehind_rel) continue;
        if (!(dot(entry->normal, per_z) < 0)) continue;
        shown = Shaped{pixel,
                       static_cast<uint32_t>(k),
                       entry->element,
                       static_cast<float>(entry->t),
                       cast<float>(entry->normal),
                       static_cast<float>(entry->at.x)};
        break;
      }
      if (options_.beside) beside_solids(g, pixel, shown);
      if (!shown) continue;
      for (size_t c = 0; c < 3; ++c) normal[c * g.pixels + pixel] = alpha * shown->normal[c];
      zdepth[pixel] = alpha * shown->t;
      frame.outline.shapes[pixel] = (shown->shape == kBeside ? static_cast<uint32_t>(shapes.size()) : shown->shape) + 1;
      bands_[band].push_back(*shown);
    }
  });
}

// What stands out of the solids, where the pixel shows it and not the solid.
void ShapePass::beside_solids(const GBuffer& g, uint32_t pixel, std::optional<Shaped>& shown) const {
  const PixelRay<float> ray = g.ray(pixel);
  const auto entry = options_.beside->entry(ray.eye, ray.direction_per_z);
  if (!entry || !(dot(entry->normal, ray.direction_per_z) < 0)) return;
  const float per_z = length(ray.direction_per_z), tolerance = options_.beside->tolerance();
  const float in_front = (entry->t - g.zdepth[pixel] / g.alpha[pixel]) * per_z;
  if (in_front > tolerance || in_front < -kFarBehind * tolerance) return;
  if (shown && ((entry->t - shown->t) * per_z > 0 ||
                (dot(entry->normal, shown->normal) > kSameSurface && (shown->t - entry->t) * per_z < kSameHeight * tolerance)))
    return;
  shown = Shaped{pixel, kBeside, entry->face, entry->t, entry->normal, entry->u, entry->v};
}

// Of the pixels that sent rays, and of those that outlines cross, for their outline alone: it was not their middle that mirrored
// (OutlinePass). What losses on normals and depths want is meant for the surfels.
void ShapePass::shape_gradients(const Frame& frame) {
  const std::vector<SurfaceOfRevolution>& shapes = *options_.shapes;
  gradients_.clear();
  for (const SurfaceOfRevolution& s : shapes) gradients_.emplace_back(parameter_count(s), 0.0);
  beside_gradient_.clear();
  std::optional<MeshSlopes> slopes;
  const ShadedPixels& s = frame.shaded;
  std::vector<uint32_t> group_of(frame.pixel_count(), UINT32_MAX);
  for (size_t g = 0; g < s.groups(); ++g) group_of[s.chosen_pixel(g)] = static_cast<uint32_t>(g);
  for (const OutlinePixel& p : frame.outline.pixels)
    if (p.crossed) group_of[p.pixel] = UINT32_MAX;
  const Vec3d eye = frame.view->centre_in_world();
  for (const auto& band : bands_)
    for (const Shaped& at : band) {
      const uint32_t group = group_of[at.pixel];
      if (group == UINT32_MAX) continue;
      const SurfacePoint<float>& grad = s.grad_points[group];
      const Vec3f on_normal = grad.normal + grad.cosine * s.rays[group].view;
      const Vec3d per_z = cast<double>(s.rays[group].direction_per_z), on_point = cast<double>(grad.position);
      if (at.shape == kBeside) {
        if (!slopes) {
          slopes.emplace(options_.beside->mesh());
          beside_gradient_.assign(options_.beside->mesh().positions.size(), 0.0);
        }
        const Vec3d n = cast<double>(at.normal), along = cast<double>(on_normal) - dot(cast<double>(on_normal), n) * n;
        const double against = std::min(dot(n, per_z), -kGrazing * length(per_z));
        slopes->add({at.t, at.normal, at.line, at.u, at.v}, along, dot(on_point, per_z) / against, beside_gradient_);
        continue;
      }
      const ShapeHit hit{double(at.t), cast<double>(at.normal), at.line, {double(at.u), 0}};
      shapes[at.shape].hit_vjp({eye, per_z}, hit, {dot(on_point, per_z), cast<double>(on_normal)}, gradients_[at.shape]);
    }
  const OutlineImages& outline = frame.outline;
  for (size_t i = 0; i < outline.grad_covered.size(); ++i) {
    const OutlinePixel& p = outline.pixels[i];
    if (outline.grad_covered[i] == 0) continue;
    if (p.shape < shapes.size())
      outline_vjp(p, shapes[p.shape], double(outline.grad_covered[i]), gradients_[p.shape]);
    else {
      beside_gradient_.resize(options_.beside->mesh().positions.size(), 0.0);
      outline_vjp(p, *options_.beside, double(outline.grad_covered[i]), beside_gradient_);
    }
  }
}

// N = A n and Z = A z, n and z of the solid.
void ShapePass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  gradients_.clear();
  beside_gradient_.clear();
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
