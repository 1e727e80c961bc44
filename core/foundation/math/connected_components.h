// Connected components of a graph by breadth-first search: face-connected voxels of a grid, or touching sparse cells.
//
// Components are numbered by their lowest node. Members are in search order: from the lowest node, following the neighbour
// order. O(nodes + edges).
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace vitrine {

struct ConnectedComponents {
  static constexpr uint32_t kNone = UINT32_MAX;
  std::vector<uint32_t> label;               // [node] component or kNone
  std::vector<std::vector<size_t>> members;  // [component] nodes
};

// Components of the nodes 0 .. count - 1 for which within(node) holds. for_neighbours(node, visit) calls visit(other) for each
// neighbour and must be symmetric.
template <class Within, class ForNeighbours>
ConnectedComponents connected_components(size_t count, const Within& within, const ForNeighbours& for_neighbours) {
  ConnectedComponents out;
  out.label.assign(count, ConnectedComponents::kNone);
  for (size_t first = 0; first < count; ++first) {
    if (out.label[first] != ConnectedComponents::kNone || !within(first)) continue;
    const auto number = static_cast<uint32_t>(out.members.size());
    std::vector<size_t> members{first};
    out.label[first] = number;
    for (size_t next = 0; next < members.size(); ++next)
      for_neighbours(members[next], [&](size_t node) {
        if (out.label[node] != ConnectedComponents::kNone || !within(node)) return;
        out.label[node] = number;
        members.push_back(node);
      });
    out.members.push_back(std::move(members));
  }
  return out;
}

using CellIndex = std::array<int, 3>;

// Components of cells of an unbounded grid (sorted, unique) that share a face, an edge or a corner.
inline ConnectedComponents connected_cells(std::span<const CellIndex> cells) {
  return connected_components(
      cells.size(), [](size_t) { return true; },
      [&](size_t i, const auto& visit) {
        for (int n = 0; n < 27; ++n) {
          const CellIndex other{cells[i][0] + n % 3 - 1, cells[i][1] + n / 3 % 3 - 1, cells[i][2] + n / 9 - 1};
          const auto at = std::ranges::lower_bound(cells, other);
          if (at != cells.end() && *at == other) visit(static_cast<size_t>(at - cells.begin()));
        }
      });
}

// Disjoint sets of the numbers 0 .. n - 1 (union-find with path halving; Tarjan and van Leeuwen, "Worst-case analysis of set
// union algorithms", 1984): incremental connected components. The representative of a set is its smallest member.
class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0u); }

  uint32_t representative(uint32_t i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void unite(uint32_t i, uint32_t j) {
    const uint32_t a = representative(i), b = representative(j);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> parent_;
};

}  // namespace vitrine
