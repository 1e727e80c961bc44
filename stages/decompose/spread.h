// Interpolation of irradiance from points to surfels: nearest points on the same side of the surface, weighted by distance and
// angle.
#pragma once

#include <span>
#include <vector>

#include "core/scene/surfels/layers.h"
#include "stages/decompose/lit_points.h"

namespace vitrine {

struct SpreadDesc {
  float inner_radius = 0.01f, outer_radius = 0.06f;  // distance of neighbouring points
  size_t neighbours = 8;
};

// One per surfel. `usable[i]` = false: the point is ignored. Surfels far from every usable point get the mean of all.
std::vector<Vec3f> spread_irradiance(const SplatLayer& layer, const Bounds3& inner, std::span<const LitPoint> points,
                                     std::span<const Vec3f> irradiance, const std::vector<bool>& usable, const SpreadDesc& desc);

// View-independent colour of a surfel: the mean over the cameras in front of it.
std::vector<Vec3f> surfel_radiance(const SplatLayer& layer, std::span<const Vec3f> eyes);

}  // namespace vitrine
