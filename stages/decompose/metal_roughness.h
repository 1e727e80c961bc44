// How rough a metal is, from how much contrast is left in what it mirrors. Comparing pixels does not tell: normals are never so
// good that a ray meets what its pixel shows, and whatever is blurred more then fits better (metal of roughness .22: least
// error at .33). How much neighbouring pixels differ does not depend on where exactly they look. The more roughness, the less.
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

// Pixels of one thing that show what is well known in the mirror; [pixel] each.
struct MirroredPixels {
  std::vector<int> view, x, y;
  std::vector<Vec3f> origins, normals, towards_eye;  // on its surface, world, unit
  std::vector<Vec3f> photo;                          // linear radiance
  size_t size() const { return view.size(); }
};

// Radiance that comes to `origins` from `directions`.
using LightAlong = std::function<std::vector<Vec3f>(std::span<const Vec3f> origins, std::span<const Vec3f> directions)>;

// The roughness (GGX alpha = its square) at which a metal of this reflectance shows as much contrast as the photos do; empty: too
// few pixels have neighbours.
std::optional<float> roughness_of_contrast(const MirroredPixels& pixels, const Vec3f& reflectance, const LightAlong& light);

}  // namespace vitrine
