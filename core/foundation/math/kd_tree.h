// Nearest points of a fixed set: a balanced k-d tree.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
class KdTree {  // of float or double
 public:
  // The points stay with the caller. Those that are no numbers are never found.
  explicit KdTree(std::span<const Vec3<T>> points);
  struct Near {
    T squared_distance;
    uint32_t index;
    auto operator<=>(const Near&) const = default;
  };
  // At most `count` points within `radius` of p, nearest first; of equal ones the smaller index.
  void nearest(const Vec3<T>& p, size_t count, T radius, std::vector<Near>& out) const { search(p, count, radius, kNone, out); }
  // The `count` points nearest to point `self` of the set, without itself.
  void nearest_others(uint32_t self, size_t count, std::vector<Near>& out) const {
    search(points_[self], count, std::numeric_limits<T>::infinity(), self, out);
  }
  // Whether there is a point within `radius` of p; false for a p that is no number.
  bool any(const Vec3<T>& p, T radius) const;

 private:
  static constexpr uint32_t kNone = UINT32_MAX;
  struct Query;
  void build(size_t begin, size_t end);
  void search(const Vec3<T>& p, size_t count, T radius, uint32_t self, std::vector<Near>& out) const;
  void visit(size_t begin, size_t end, Query& query) const;

  std::span<const Vec3<T>> points_;
  std::vector<uint32_t> order_;  // the middle of a range is its node, what is before and after it are its children
  std::vector<uint8_t> axis_;    // along which the middle splits its range
};

using KdTreef = KdTree<float>;
using KdTreed = KdTree<double>;
extern template class KdTree<float>;
extern template class KdTree<double>;

}  // namespace vitrine
