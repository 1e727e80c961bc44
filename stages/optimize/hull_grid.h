// Cells of equal size in a box, and a value in each: what a hull is carved from.
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "core/base/parallel.h"
#include "core/math/vec.h"

namespace vitrine {

template <class T>
struct HullGrid {
  Vec3d origin;  // of the corner of cell (0, 0, 0)
  double cell;
  std::array<int, 3> size;
  std::vector<T> values;

  size_t index(int x, int y, int z) const { return (size_t(z) * size_t(size[1]) + size_t(y)) * size_t(size[0]) + size_t(x); }
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

  // visit(x, y, z) for every cell; of a layer of equal z in order, layers side by side.
  template <class F>
  void each(F visit) const {
    parallel_for(size_t(size[2]), 1, [&](size_t z) {
      for (int y = 0; y < size[1]; ++y)
        for (int x = 0; x < size[0]; ++x) visit(x, y, int(z));
    });
  }
  // The same, one after the other.
  template <class F>
  void each_in_order(F visit) const {
    for (int z = 0; z < size[2]; ++z)
      for (int y = 0; y < size[1]; ++y)
        for (int x = 0; x < size[0]; ++x) visit(x, y, z);
  }
};

}  // namespace vitrine
