#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/connected_components.h"

namespace vitrine {
namespace {

// A row of cells; those of `within` that follow each other are connected.
ConnectedComponents runs(const std::vector<int>& within) {
  return connected_components(
      within.size(), [&](size_t i) { return within[i] != 0; },
      [&](size_t i, const auto& visit) {
        if (i + 1 < within.size()) visit(i + 1);
        if (i > 0) visit(i - 1);
      });
}

TEST(ConnectedComponents, AreNumberedByTheirLowestNode) {
  const ConnectedComponents found = runs({0, 1, 1, 0, 1, 0, 0, 1, 1, 1});
  constexpr uint32_t kNone = ConnectedComponents::kNone;
  EXPECT_EQ(found.label, (std::vector<uint32_t>{kNone, 0, 0, kNone, 1, kNone, kNone, 2, 2, 2}));
  EXPECT_EQ(found.members, (std::vector<std::vector<size_t>>{{1, 2}, {4}, {7, 8, 9}}));
  EXPECT_TRUE(runs({}).members.empty());
  EXPECT_TRUE(runs({0, 0}).members.empty());
}

TEST(ConnectedComponents, ListMembersByTheirDistanceFromTheFirst) {
  // 0 - 3 - 1 and 0 - 2: neighbours of 0 before those of 3.
  const std::vector<std::vector<size_t>> neighbours{{3, 2}, {3}, {0}, {0, 1}};
  const ConnectedComponents found = connected_components(
      4, [](size_t) { return true; },
      [&](size_t i, const auto& visit) {
        for (size_t j : neighbours[i]) visit(j);
      });
  EXPECT_EQ(found.members, (std::vector<std::vector<size_t>>{{0, 3, 2, 1}}));
}

TEST(ConnectedCells, TouchAtFacesEdgesAndCorners) {
  const std::vector<CellIndex> cells{{-1, -1, -1}, {0, 0, 0}, {0, 1, 0}, {0, 3, 0}, {1, 2, -1}, {5, 5, 5}};
  const ConnectedComponents found = connected_cells(cells);
  EXPECT_EQ(found.label, (std::vector<uint32_t>{0, 0, 0, 0, 0, 1}));
}

TEST(DisjointSets, AgreeWithTheSearchOnRandomGraphs) {
  Rng rng(6);
  for (int trial = 0; trial < 20; ++trial) {
    constexpr size_t kNodes = 60;
    std::vector<std::vector<size_t>> neighbours(kNodes);
    DisjointSets sets(kNodes);
    for (int edge = 0; edge < 25 + trial; ++edge) {
      const uint32_t a = rng.below(kNodes), b = rng.below(kNodes);
      neighbours[a].push_back(b), neighbours[b].push_back(a);
      sets.unite(a, b);
    }
    const ConnectedComponents found = connected_components(
        kNodes, [](size_t) { return true; },
        [&](size_t i, const auto& visit) {
          for (size_t j : neighbours[i]) visit(j);
        });
    for (uint32_t i = 0; i < kNodes; ++i) EXPECT_EQ(sets.representative(i), found.members[found.label[i]].front());
  }
}

}  // namespace
}  // namespace vitrine
