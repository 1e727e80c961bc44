// Interpolates the depth of a pixel from the nearest known depths in the same photo. Used for initial surfels, which need only
// an approximate position.
#pragma once

#include <optional>
#include <span>

namespace vitrine {

struct PixelDepth {
  double x, y, z;  // pixels, z-depth
};

struct BorrowedDepth {
  double z = 0;       // mean inverse of the three nearest, weighted by 1 / (squared distance + 1)
  double spread = 1;  // farthest of them over nearest: much more than 1 = different surfaces
};
// Empty when none of `known` is within `reach` pixels of (x, y).
std::optional<BorrowedDepth> borrowed_depth(std::span<const PixelDepth> known, double x, double y, double reach);

}  // namespace vitrine
