// Roughness of a metal from the contrast of its reflections. A pixel comparison fails: normals are never exact, so more blur
// always fits better (metal of roughness .22: least error at .33). The difference between neighbouring pixels does not depend on
// exact ray directions and decreases with roughness.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

// Pixels of one object that reflect well-known content; [pixel] each.
struct MirroredPixels {
  std::vector<int> view, x, y;
  std::vector<Vec3f> origins, normals, towards_eye;  // on its surface, world, unit
  std::vector<Vec3f> photo;                          // linear radiance
  size_t size() const { return view.size(); }
};

// Radiance that arrives at `origins` from `directions`.
using LightAlong = std::function<std::vector<Vec3f>(std::span<const Vec3f> origins, std::span<const Vec3f> directions)>;

// Roughness (GGX alpha = its square) at which a metal of this reflectance has the contrast of the photos; empty: too few pixels
// with neighbours.
std::optional<float> roughness_of_contrast(const MirroredPixels& pixels, const Vec3f& reflectance, const LightAlong& light);

}  // namespace vitrine
