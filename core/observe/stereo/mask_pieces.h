// The connected pieces of a mask, and those that are quadrilaterals: the picture of a rectangle is one.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/observe/stereo/silhouette.h"

namespace vitrine {

struct MaskPieces {
  static constexpr uint32_t kNone = UINT32_MAX;
  std::vector<uint32_t> label;              // [h,w] piece of a marked pixel, or kNone
  std::vector<std::vector<size_t>> pixels;  // [piece]
};
MaskPieces mask_pieces(const Silhouette& mask);

// Corners in pixels, clockwise as the picture is looked at (y down).
struct Quadrilateral {
  std::array<Vec2d, 4> corners;
  double area = 0;
};
// Pieces of at least `least_share` of the picture, away from its border, whose convex hull four corners fit. Things in front of
// an edge may cut a part of it away.
std::vector<Quadrilateral> quadrilaterals(const Silhouette& mask, double least_share);

// Counter-clockwise for y up, clockwise for y down, without points on its edges (Andrew 1979).
std::vector<Vec2d> convex_hull(std::vector<Vec2d> points);

}  // namespace vitrine
