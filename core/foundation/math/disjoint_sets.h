// Disjoint sets of the numbers 0 .. n - 1 (union-find with path halving; Tarjan and van Leeuwen, "Worst-case analysis of set
// union algorithms", 1984): incremental connected components. The representative of a set is its smallest member.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace vitrine {

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
