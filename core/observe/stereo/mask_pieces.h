// Connected components of a mask, and those that are quadrilaterals, the projections of rectangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/observe/stereo/silhouette.h"

namespace vitrine {

struct MaskPieces {
  static constexpr uint32_t kNone = UINT32_MAX;
  std::vector<uint32_t> label;              // [h,w] component index of a marked pixel, or kNone
  std::vector<std::vector<size_t>> pixels;  // [piece]
};
MaskPieces mask_pieces(const Silhouette& mask);

// Corners in pixels, clockwise in the photo (y down).
struct Quadrilateral {
  std::array<Vec2d, 4> corners;
  double area = 0;
};
// Components of at least `least_share` of the photo, not at its border, whose convex hull is close to a quadrilateral.
// Occluders may cut off a part of an edge.
std::vector<Quadrilateral> quadrilaterals(const Silhouette& mask, double least_share);

// Counter-clockwise for y up, clockwise for y down, without points on its edges (Andrew 1979).
std::vector<Vec2d> convex_hull(std::vector<Vec2d> points);

}  // namespace vitrine
