// Shading position and ray origin of a pixel (README 4). Surfels and mesh differ by about one edge length of the mesh; rays
// must start outside that distance.
#pragma once

#include <span>

#include "core/render/model/gbuffer.h"
#include "core/render/relight/microfacet.h"
#include "core/render/relight/scene_surface.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

// The surface of a pixel, from the rasteriser.
struct ShownSurface {
  PixelRay<float> ray;
  Vec3f normal{};  // sum of the blended normals; non-zero if there is a surface
  float alpha = 0, z = 0;
  RelitMaterial material;  // lit_place() sets its normal consistency
  bool behind_glass = false;
};

// `surface`: channels of a picture with alpha > 0 in the pixel; `median_z`: the channel of that name.
ShownSurface shown_surface(const GBuffer& surface, std::span<const float> median_z, uint32_t pixel, const PixelRay<float>& ray);

struct LitPlace {
  Vec3f normal{};   // unit, facing the eye
  Vec3f place{};    // on the surface
  Vec3f on_mesh{};  // where the eye ray hits the mesh, if that is the same surface; otherwise `place`
  Vec3f origin{};   // of rays, slightly above the surface
  float agreement = 1;
};

// `shapes`: known mirror shapes, or nullptr.
LitPlace lit_place(const SceneSurface& surface, const ShapeSet* shapes, LayerBlend blend, const ShownSurface& shown);

// Offset of ray origins above a mirror, scene units.
float mirror_lift(const SceneSurface& surface);

}  // namespace vitrine
