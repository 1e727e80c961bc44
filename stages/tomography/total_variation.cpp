#include "stages/tomography/total_variation.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {

constexpr int kIterations = 10;

}  // namespace

TotalVariation::TotalVariation(const VoxelGrid<float>& grid) : smooth_(grid.count(), 0.f) {
  for (std::vector<float>& d : dual_) d.assign(grid.count(), 0.f);
}

void TotalVariation::reduce(VoxelGrid<float>& grid, float weight) {
  auto& [dx, dy, dz] = dual_;
  const size_t next_y = size_t(grid.size[0]), next_z = next_y * size_t(grid.size[1]);
  const float rate = 1 / (12 * weight);  // 12: the largest eigenvalue of the Laplacian of a grid
  for (int iteration = 0;; ++iteration) {
    grid.each([&](int x, int y, int z) {
      const size_t i = grid.index(x, y, z);
      const float divergence =
          dx[i] + dy[i] + dz[i] - (x > 0 ? dx[i - 1] : 0) - (y > 0 ? dy[i - next_y] : 0) - (z > 0 ? dz[i - next_z] : 0);
      smooth_[i] = std::max(0.f, grid.values[i] + weight * divergence);
    });
    if (iteration == kIterations) break;
    grid.each([&](int x, int y, int z) {
      const size_t i = grid.index(x, y, z);
      const float a = x + 1 < grid.size[0] ? dx[i] + rate * (smooth_[i + 1] - smooth_[i]) : 0;
      const float b = y + 1 < grid.size[1] ? dy[i] + rate * (smooth_[i + next_y] - smooth_[i]) : 0;
      const float c = z + 1 < grid.size[2] ? dz[i] + rate * (smooth_[i + next_z] - smooth_[i]) : 0;
      const float shrink = 1 / std::max(1.f, std::sqrt(a * a + b * b + c * c));
      dx[i] = shrink * a, dy[i] = shrink * b, dz[i] = shrink * c;
    });
  }
  grid.values = smooth_;
}

}  // namespace vitrine
