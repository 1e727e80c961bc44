// Voxel grid of cubic cells with one value per cell, for visual hulls and voting.
//
// Cell (x, y, z) spans origin + cell [x, x + 1) and so on; values are [z][y][x].
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/connected_components.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
struct VoxelGrid {
  Vec3d origin{};   // corner of cell (0, 0, 0)
  double cell = 0;  // cell edge length
  std::array<int, 3> size{};
  std::vector<T> values;

  size_t count() const { return size_t(size[0]) * size_t(size[1]) * size_t(size[2]); }
  size_t index(int x, int y, int z) const { return (size_t(z) * size_t(size[1]) + size_t(y)) * size_t(size[0]) + size_t(x); }
  std::array<int, 3> cell_at(size_t index) const {
    const size_t columns = size_t(size[0]), rows = size_t(size[1]);
    return {int(index % columns), int(index / columns % rows), int(index / columns / rows)};
  }
  bool has(int x, int y, int z) const { return x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2]; }
  T at(int x, int y, int z) const { return has(x, y, z) ? values[index(x, y, z)] : T{}; }
  std::array<int, 3> cell_of(const Vec3d& p) const {
    const Vec3d q = (p - origin) / cell;
    return {int(std::floor(q.x)), int(std::floor(q.y)), int(std::floor(q.z))};
  }
  T at(const Vec3d& p) const {
    const auto [x, y, z] = cell_of(p);
    return at(x, y, z);
  }
  Vec3d centre(int x, int y, int z) const { return origin + cell * Vec3d{x + 0.5, y + 0.5, z + 0.5}; }
  Vec3d high() const { return origin + cell * Vec3d{double(size[0]), double(size[1]), double(size[2])}; }

  // Calls visit(x, y, z) for every cell; in order within a z layer, layers in parallel.
  template <class F>
  void each(F visit) const {
    parallel_for(size_t(size[2]), 1, [&](size_t z) {
      for (int y = 0; y < size[1]; ++y)
        for (int x = 0; x < size[0]; ++x) visit(x, y, int(z));
    });
  }
  // Same, sequential.
  template <class F>
  void each_in_order(F visit) const {
    for (int z = 0; z < size[2]; ++z)
      for (int y = 0; y < size[1]; ++y)
        for (int x = 0; x < size[0]; ++x) visit(x, y, z);
  }
};

// Components of face-connected cells for which within(index) holds.
template <class T, class Within>
ConnectedComponents connected_components(const VoxelGrid<T>& grid, const Within& within) {
  return connected_components(grid.count(), within, [&](size_t i, const auto& visit) {
    const auto [x, y, z] = grid.cell_at(i);
    for (const int d : {1, -1})
      if (grid.has(x + d, y, z)) visit(grid.index(x + d, y, z));
    for (const int d : {1, -1})
      if (grid.has(x, y + d, z)) visit(grid.index(x, y + d, z));
    for (const int d : {1, -1})
      if (grid.has(x, y, z + d)) visit(grid.index(x, y, z + d));
  });
}

}  // namespace vitrine
