// Nearest neighbour search in a fixed point set: a balanced k-d tree.
#pragma once

#include <compare>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
class KdTree {  // float or double
 public:
  // The caller keeps the points alive. NaN points are never found.
  explicit KdTree(std::span<const Vec3<T>> points);
  struct Near {
    T squared_distance;
    uint32_t index;
    auto operator<=>(const Near&) const = default;
  };
  // At most `count` points within `radius` of p, nearest first; ties: lower index.
  void nearest(const Vec3<T>& p, size_t count, T radius, std::vector<Near>& out) const { search(p, count, radius, kNone, out); }
  // The `count` nearest neighbours of point `self` of the set, excluding itself.
  void nearest_others(uint32_t self, size_t count, std::vector<Near>& out) const {
    search(points_[self], count, std::numeric_limits<T>::infinity(), self, out);
  }
  // True if a point lies within `radius` of p; false if p is NaN.
  bool any(const Vec3<T>& p, T radius) const;

 private:
  static constexpr uint32_t kNone = UINT32_MAX;
  struct Query;
  void build(size_t begin, size_t end);
  void search(const Vec3<T>& p, size_t count, T radius, uint32_t self, std::vector<Near>& out) const;
  void visit(size_t begin, size_t end, Query& query) const;

  std::span<const Vec3<T>> points_;
  std::vector<uint32_t> order_;  // the middle of a range is its node, the parts before and after it are its children
  std::vector<uint8_t> axis_;    // split axis of the range whose middle it is
};

using KdTreef = KdTree<float>;
using KdTreed = KdTree<double>;
extern template class KdTree<float>;
extern template class KdTree<double>;

}  // namespace vitrine
