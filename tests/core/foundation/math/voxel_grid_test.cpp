#include <gtest/gtest.h>

#include "core/foundation/math/voxel_grid.h"

namespace vitrine {
namespace {

TEST(VoxelGrid, FindsCellsByIndexAndByPlace) {
  VoxelGrid<int> grid{{-1, 0, 2}, 0.5, {4, 3, 2}, {}};
  grid.values.resize(grid.count());
  for (size_t i = 0; i < grid.count(); ++i) grid.values[i] = int(i) + 1;
  int next = 0;
  grid.each_in_order([&](int x, int y, int z) {
    EXPECT_EQ(grid.index(x, y, z), size_t(next));
    EXPECT_EQ(grid.cell_at(size_t(next)), (std::array{x, y, z}));
    EXPECT_EQ(grid.cell_of(grid.centre(x, y, z)), (std::array{x, y, z}));
    EXPECT_EQ(grid.at(grid.centre(x, y, z)), ++next);
  });
  EXPECT_EQ(next, 24);
  EXPECT_EQ(grid.centre(1, 2, 0), (Vec3d{-0.25, 1.25, 2.25}));
  EXPECT_EQ(grid.high(), (Vec3d{1, 1.5, 3}));
  EXPECT_EQ(grid.at(-1, 0, 0), 0) << "outside";
  EXPECT_EQ(grid.at(Vec3d{1.01, 0, 2}), 0) << "outside";
  EXPECT_FALSE(grid.has(0, 3, 0));
}

TEST(VoxelGrid, EachVisitsEveryCellOnce) {
  VoxelGrid<int> grid{{}, 1, {5, 7, 9}, {}};
  grid.values.assign(grid.count(), 0);
  grid.each([&](int x, int y, int z) { ++grid.values[grid.index(x, y, z)]; });
  for (int visits : grid.values) EXPECT_EQ(visits, 1);
}

TEST(VoxelGrid, CellsThatShareFacesAreConnected) {
  VoxelGrid<int> grid{{}, 1, {3, 3, 2}, {}};
  grid.values = {1, 1, 0, 0, 0, 1, 1, 0, 1,   // z = 0
                 0, 0, 0, 0, 0, 1, 0, 0, 0};  // z = 1
  const ConnectedComponents found = connected_components(grid, [&](size_t i) { return grid.values[i] != 0; });
  // (2, 1, 0) reaches (2, 2, 0) and (2, 1, 1); an edge or the end of a row connects nothing.
  EXPECT_EQ(found.members, (std::vector<std::vector<size_t>>{{0, 1}, {5, 8, 14}, {6}}));
}

}  // namespace
}  // namespace vitrine
