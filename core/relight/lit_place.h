// Where the light of a pixel is found (README 4): surfels and mesh agree to about an edge length of the mesh, and rays must start
// free of it.
#pragma once

#include <span>

#include "core/model/gbuffer.h"
#include "core/relight/microfacet.h"
#include "core/relight/scene_surface.h"
#include "core/shape/shape_set.h"

namespace vitrine {

// What a pixel shows, as the rasteriser has it.
struct ShownSurface {
  PixelRay<float> ray;
  Vec3f normal{};  // sum of the blended normals, not zero where there is one
  float alpha = 0, z = 0;
  RelitMaterial material;  // its agreement is found below
  bool behind_glass = false;
};

// `surface`: channels of a picture, its alpha in the pixel above 0; `median_z`: the channel of that name.
ShownSurface shown_surface(const GBuffer& surface, std::span<const float> median_z, uint32_t pixel, const PixelRay<float>& ray);

struct LitPlace {
  Vec3f normal{};   // unit, facing the eye
  Vec3f place{};    // of the surface
  Vec3f on_mesh{};  // where the eye's ray meets the mesh, if that is the same surface; else `place`
  Vec3f origin{};   // of rays, a little above
  float agreement = 1;
};

// `shapes`: known surfaces of mirrors, or nullptr.
LitPlace lit_place(const SceneSurface& surface, const ShapeSet* shapes, LayerBlend blend, const ShownSurface& shown);

// How far rays start above a mirror, scene units.
float mirror_lift(const SceneSurface& surface);

}  // namespace vitrine
