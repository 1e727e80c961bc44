#include "core/render/relight/lit_place.h"

#include <algorithm>
#include <cmath>

#include "core/render/model/shape_pass.h"
#include "core/render/raster/raster_desc.h"

namespace vitrine {

namespace {

constexpr float kSnap = 3;         // in grains: at a smaller distance, surfel and mesh are the same surface
constexpr float kMirrorLift = 1;   // in grains: offset of rays above a mirror
constexpr float kMattLift = 2.5f;  // the same for diffuse surfaces: the staircase of the mesh casts no shadow
constexpr float kNearWall_rel =
    0.75f;                             // a wall back face beyond this share of the pixel's distance is the surface of the surfels
constexpr float kLeastCosine = 0.02f;  // minimum n.v: blended normals at silhouettes may face away

// True if the surface reflects more than it scatters and transmits.
bool mirrors(LayerBlend blend, const RelitMaterial& m) {
  const LayerWeights<float> w = relit_weights(blend, m, 1);
  const Vec3f rest = hadamard(w.diffuse, m.albedo) + w.transmission;
  return w.reflection.x + w.reflection.y + w.reflection.z > rest.x + rest.y + rest.z;
}

Vec3f turned_to(const Vec3f& normal, const Vec3f& view) {
  const float cosine = dot(normal, view);
  return cosine >= kLeastCosine ? normal : normalized(normal + (kLeastCosine - cosine) * view);
}

}  // namespace

ShownSurface shown_surface(const GBuffer& g, std::span<const float> median_z, uint32_t pixel, const PixelRay<float>& ray) {
  const float alpha = g.alpha[pixel];
  return {.ray = ray,
          .normal = g.rgb(g.normal, pixel),
          .alpha = alpha,
          .z = surface_depth(g.zdepth[pixel], alpha, median_z[pixel]),
          .material = {.albedo = g.rgb(g.color, pixel) / alpha,
                       .f0 = g.rgb(g.f0, pixel) / alpha,
                       .roughness = std::min(g.roughness[pixel] / alpha, 1.f),
                       .specular = g.specular[pixel] / alpha,
                       .transmission = g.transmission[pixel] / alpha}};
}

float mirror_lift(const SceneSurface& surface) { return kMirrorLift * surface.grain(); }

// Shadows come from the mesh. A ray starts on the mesh if that is the same surface, or if the mesh hides the surfels (low
// coverage at silhouettes). If the pixel misses the mesh, the ray starts towards the eye, never from inside. Mirrors use the mesh
// normal, since training adapts theirs to the reflected image, and start close to the mesh, since the reflection shifts with the
// ray origin. Diffuse rays start above pits of the mesh that surfels fill. Mirrors of known shape use its position and normal.
LitPlace lit_place(const SceneSurface& surface, const ShapeSet* shapes, LayerBlend blend, const ShownSurface& shown) {
  const PixelRay<float>& ray = shown.ray;
  const float snap = kSnap * surface.grain(), lift = mirror_lift(surface), t = shown.z * length(ray.direction_per_z);
  const bool mirror = mirrors(blend, shown.material);
  LitPlace out;
  out.normal = turned_to(squared_length(shown.normal) > 0 ? normalized(shown.normal) : ray.view, ray.view);
  out.place = out.on_mesh = ray.eye + shown.z * ray.direction_per_z;
  // At silhouettes the blended normal mixes several surfaces; mirrors use the mesh normal instead, and their normal consistency
  // is 1: otherwise a pure reflector would be black.
  out.agreement = mirror ? 1 : normal_agreement(shown.normal, shown.alpha);
  Vec3f outwards = ray.view;
  // Walls of the surroundings are coarse and may lie in front of surfels, far in front in corners. Surfels seen through the front
  // of a wall get the light on that front, not the darkness behind it.
  const auto hit = shown.behind_glass ? surface.first_solid_hit(ray.eye, -ray.view) : surface.first_hit(ray.eye, -ray.view);
  if (hit && hit->t < t + snap && (!surface.surrounding(hit->face) || !hit->from_inside || hit->t > kNearWall_rel * t)) {
    out.on_mesh = ray.eye - hit->t * ray.view;
    if (mirror || hit->t < t) out.place = out.on_mesh;
    if (!hit->from_inside && mirror) out.normal = turned_to(surface.smooth_normal(*hit), ray.view);
    outwards = normalized(out.normal + (dot(hit->normal, ray.view) > 0 ? hit->normal : -hit->normal));
  }
  if (mirror && knows(shapes, ShapeRole::Mirror))
    if (const auto known = shown_mirror(*shapes, {cast<double>(ray.eye), cast<double>(ray.direction_per_z)}, double(shown.z))) {
      // In front of the mesh, which may hide the shape: behind the mesh everything is dark.
      const float there = float(known->t) * length(ray.direction_per_z);
      out.place = ray.eye - (hit ? std::min(hit->t, there) : there) * ray.view;
      out.normal = turned_to(cast<float>(known->normal), ray.view);
      outwards = out.normal;
    }
  // Near a bump of the mesh, `outwards` may point into it; the segment towards the eye is free.
  const Vec3f free = out.place + lift * ray.view;
  const Vec3f above = out.place + (mirror ? lift : kMattLift * surface.grain()) * outwards;
  out.origin = surface.free_between(free, above) ? above : free;
  return out;
}

}  // namespace vitrine
