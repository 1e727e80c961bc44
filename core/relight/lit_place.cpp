#include "core/relight/lit_place.h"

#include <algorithm>
#include <cmath>

#include "core/model/shape_pass.h"
#include "core/render/surface_depth.h"

namespace vitrine {

namespace {

constexpr float kSnap = 3;              // in grains: a surfel's place and the mesh this near are the same surface
constexpr float kMirrorLift = 1;        // in grains: where rays start above it
constexpr float kMattLift = 2.5f;       // the same where light is scattered: terraces of the mesh throw no shadow
constexpr float kNearWall_rel = 0.75f;  // a back of the walls that hides surfels by less is where they are
constexpr float kLeastCosine = 0.02f;   // n.v: normals of blended surfels may look away at an outline

// More than it scatters or lets through.
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

// Shadows come from the mesh: a ray starts on it where it means the same surface, and where it hides what the surfels show (thin
// coverage at an outline); where the pixel misses the mesh, it starts towards the eye: never from inside. Mirrors have its
// normals, too: training leaves theirs as the pictures in them want them. And their rays start right there, for a picture in a
// mirror shifts with where its ray starts; those of matt things start before pits of the mesh that surfels fill. A mirror of
// known shape has place and normal of that.
LitPlace lit_place(const SceneSurface& surface, const ShapeSet* shapes, LayerBlend blend, const ShownSurface& shown) {
  const PixelRay<float>& ray = shown.ray;
  const float snap = kSnap * surface.grain(), lift = mirror_lift(surface), t = shown.z * length(ray.direction_per_z);
  const bool mirror = mirrors(blend, shown.material);
  LitPlace out;
  out.normal = turned_to(squared_length(shown.normal) > 0 ? normalized(shown.normal) : ray.view, ray.view);
  out.place = out.on_mesh = ray.eye + shown.z * ray.direction_per_z;
  // At a rim the blended normal looks at nothing in particular; that of the mesh is one surface's. What reflects alone would be
  // black there.
  out.agreement = mirror ? 1 : normal_agreement(shown.normal, shown.alpha);
  Vec3f outwards = ray.view;
  // Walls around the scene are coarse, and in front of surfels here and there, by much in a corner: what the eye sees through
  // their front has the light that falls on it, not the dark behind it.
  const auto hit = shown.behind_glass ? surface.first_solid_hit(ray.eye, -ray.view) : surface.first_hit(ray.eye, -ray.view);
  if (hit && hit->t < t + snap && (!surface.surrounding(hit->face) || !hit->from_inside || hit->t > kNearWall_rel * t)) {
    out.on_mesh = ray.eye - hit->t * ray.view;
    if (mirror || hit->t < t) out.place = out.on_mesh;
    if (!hit->from_inside && mirror) out.normal = turned_to(surface.smooth_normal(*hit), ray.view);
    outwards = normalized(out.normal + (dot(hit->normal, ray.view) > 0 ? hit->normal : -hit->normal));
  }
  if (mirror && knows(shapes, ShapeRole::Mirror))
    if (const auto known = shown_mirror(*shapes, {cast<double>(ray.eye), cast<double>(ray.direction_per_z)}, double(shown.z))) {
      // Before the mesh, which may stand before the shape: from behind it everything is dark.
      const float there = float(known->t) * length(ray.direction_per_z);
      out.place = ray.eye - (hit ? std::min(hit->t, there) : there) * ray.view;
      out.normal = turned_to(cast<float>(known->normal), ray.view);
      outwards = out.normal;
    }
  // Beside a lump of the mesh, `outwards` leads into it; towards the eye there is nothing.
  const Vec3f free = out.place + lift * ray.view;
  const Vec3f above = out.place + (mirror ? lift : kMattLift * surface.grain()) * outwards;
  out.origin = surface.free_between(free, above) ? above : free;
  return out;
}

}  // namespace vitrine
