// Total variation of a grid of voxels: the sum of the lengths of the differences to the next voxels along x, y and z.
#pragma once

#include <array>
#include <vector>

#include "core/foundation/math/voxel_grid.h"

namespace vitrine {

// Dual projection (Chambolle 2004), which goes on from the dual variables of the last call: few iterations each suffice.
class TotalVariation {
 public:
  static constexpr size_t kFloatsPerVoxel = 4;

  explicit TotalVariation(const VoxelGrid<float>& grid);
  // About the grid of least |new - old|^2 / 2 + weight TV(new), of at least 0. A flat jump between large regions shrinks by
  // `weight` times their border over their volume. Same bytes for any number of threads.
  void reduce(VoxelGrid<float>& grid, float weight);
  // What calls remember.
  std::array<std::vector<float>, 3>& dual() { return dual_; }

 private:
  std::array<std::vector<float>, 3> dual_;  // along x, y, z
  std::vector<float> smooth_;
};

}  // namespace vitrine
