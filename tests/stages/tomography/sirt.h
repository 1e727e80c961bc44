// Simultaneous iterative reconstruction (Gilbert 1972) of a grid of voxels, the usual iterative method that the fit is
// compared with: x <- max(0, x + C A' R (b - A x)), A = trilinear samples a cell apart, R and C inverse sums of rows and columns.
#pragma once

#include <functional>
#include <span>

#include "core/foundation/base/parallel.h"
#include "core/scene/image/image.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine::test {

// Calls add(cell, weight) for the samples along a ray; weights have the unit of length.
template <class Add>
void along(const VoxelGrid<float>& grid, const VolumeRay& ray, const Add& add) {
  const Vec3d middle = 0.5 * (grid.origin + grid.high());
  const double near = dot(middle - ray.origin, ray.direction), reach = 0.5 * length(grid.high() - grid.origin);
  const int steps = int(2 * reach / grid.cell) + 1;
  for (int s = 0; s < steps; ++s) {
    const Vec3d p = ray.origin + (near - reach + grid.cell * (s + 0.5)) * ray.direction;
    const Vec3d q = (p - grid.origin) / grid.cell - Vec3d{0.5, 0.5, 0.5};
    const int x = int(std::floor(q.x)), y = int(std::floor(q.y)), z = int(std::floor(q.z));
    if (x < -1 || y < -1 || z < -1 || x >= grid.size[0] || y >= grid.size[1] || z >= grid.size[2]) continue;
    const double tx = q.x - x, ty = q.y - y, tz = q.z - z;
    for (int k = 0; k < 8; ++k)
      if (grid.has(x + k % 2, y + k / 2 % 2, z + k / 4))
        add(grid.index(x + k % 2, y + k / 2 % 2, z + k / 4),
            float(grid.cell * (k % 2 ? tx : 1 - tx) * (k / 2 % 2 ? ty : 1 - ty) * (k / 4 ? tz : 1 - tz)));
  }
}

// Calls seen(iteration, grid) after each.
inline void sirt(const ScanGeometry& g, std::span<const ImageF> projections, int iterations, VoxelGrid<float>& grid,
                 const std::function<void(int)>& seen = {}) {
  grid.values.assign(grid.count(), 0.f);
  std::vector<float> columns(grid.count(), 0.f);
  std::vector<std::vector<VolumeRay>> rays;
  for (const double angle : g.angles) rays.push_back(scan_rays(g, angle));
  constexpr size_t kParts = 4;  // of the views, each with its own sum: the same bytes for any number of threads
  for (int it = -1; it < iterations; ++it) {
    std::vector<std::vector<float>> sums(kParts, std::vector<float>(grid.count(), 0.f));
    parallel_for(kParts, 1, [&](size_t part) {
      for (size_t v = part; v < rays.size(); v += kParts)
        for (size_t r = 0; r < rays[v].size(); ++r) {
          if (it < 0) {
            along(grid, rays[v][r], [&](size_t i, float w) { sums[part][i] += w; });
            continue;
          }
          float sum = 0, total = 0;
          along(grid, rays[v][r], [&](size_t i, float w) { sum += w * grid.values[i], total += w; });
          if (!(total > 0)) continue;
          const float left = (projections[v].data()[r] - sum) / total;
          along(grid, rays[v][r], [&](size_t i, float w) { sums[part][i] += w * left; });
        }
    });
    for (size_t i = 0; i < grid.count(); ++i) {
      float sum = 0;
      for (const auto& part : sums) sum += part[i];
      if (it < 0)
        columns[i] = sum;
      else if (columns[i] > 0)
        grid.values[i] = std::max(0.f, grid.values[i] + sum / columns[i]);
    }
    if (it >= 0 && seen) seen(it + 1);
  }
}

}  // namespace vitrine::test
