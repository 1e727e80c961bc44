// Silhouettes of known shapes (core/scene/shape) in a picture, of all that mirror together. They are known to a fraction of a pixel,
// and with them how much of each pixel the shapes cover; how the coverage changes with the shapes tells training where photos see
// the silhouette (algorithms 9.6).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/scene/shape/shape_set.h"

namespace vitrine {

// Pixels that lie this near to the silhouette belong to its band: surfels of the shape, which are as large as that, blur it so
// far.
inline constexpr int kSilhouetteBand = 4;

struct SilhouettePixel {
  uint32_t pixel = 0, entry = 0;  // of the set
  float covered = 0;              // by the shape, 0 to 1
  float z = 0;                    // z-depth of the shape: where the pixel shows it; else of the nearest part of the silhouette
  float away = 0;                 // pixels to the nearest pixel that the silhouette crosses
  Vec3f normal{};                 // of the shape where the pixel shows it: of the middle of what is covered
  bool crossed = false;           // by the silhouette; what follows is of those alone
  ShapeHit edge{};                // of the ray that just meets the shape
  Vec3d place{};                  // of that hit, in the world
  Vec3d grows{};                  // d covered / d place: the surface moves by dx there, covered by dot(grows, dx)
};

// Of the entries of role Mirror; pixels ascending. What reaches behind the camera has no silhouette.
std::vector<SilhouettePixel> silhouette_pixels(const ShapeSet& set, const View& view);

// From dL/d covered of a crossed pixel to the parameters of its shape, added.
void silhouette_vjp(const SilhouettePixel& at, const Shape& shape, double grad_covered, std::span<double> grad);

}  // namespace vitrine
