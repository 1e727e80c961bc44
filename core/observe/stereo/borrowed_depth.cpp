#include "core/observe/stereo/borrowed_depth.h"

#include <algorithm>
#include <array>

namespace vitrine {

std::optional<BorrowedDepth> borrowed_depth(std::span<const PixelDepth> known, double x, double y, double reach) {
  struct Near {
    double squared, z;
  };
  std::array<Near, 3> best;
  best.fill({1e300, 0});
  for (const PixelDepth& k : known) {
    if (!(k.z > 0)) continue;
    const double squared = (k.x - x) * (k.x - x) + (k.y - y) * (k.y - y);
    if (!(squared < best[2].squared)) continue;
    best[2] = {squared, k.z};
    if (best[2].squared < best[1].squared) std::swap(best[1], best[2]);
    if (best[1].squared < best[0].squared) std::swap(best[0], best[1]);
  }
  if (!(best[0].squared <= reach * reach)) return std::nullopt;
  double weights = 0, inverse = 0, nearest = 1e300, farthest = 0;
  for (const Near& n : best) {
    if (n.z == 0) continue;
    const double weight = 1 / (n.squared + 1);
    weights += weight;
    inverse += weight / n.z;
    nearest = std::min(nearest, n.z);
    farthest = std::max(farthest, n.z);
  }
  return BorrowedDepth{.z = weights / inverse, .spread = farthest / nearest};
}

}  // namespace vitrine
