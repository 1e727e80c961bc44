#include "stages/optimize/neighbours.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <numeric>

#include "core/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kNearest = 3, kLeafSize = 8;

// The points in tree order: the middle of a range is its node, split along the widest axis of the range.
class PointTree {
 public:
  explicit PointTree(std::span<const Vec3f> points) : points_(points), order_(points.size()), axis_(points.size(), 0) {
    std::iota(order_.begin(), order_.end(), 0u);
    build(0, order_.size());
  }

  // Squared distances to the nearest others of point `self`, ascending.
  std::array<float, kNearest> nearest(uint32_t self) const {
    std::array<float, kNearest> best;
    best.fill(std::numeric_limits<float>::infinity());
    search(0, order_.size(), self, best);
    return best;
  }

 private:
  void build(size_t begin, size_t end) {
    if (end - begin <= kLeafSize) return;
    Vec3f low = points_[order_[begin]], high = low;
    for (size_t i = begin; i < end; ++i)
      for (size_t c = 0; c < 3; ++c) {
        low[c] = std::min(low[c], points_[order_[i]][c]);
        high[c] = std::max(high[c], points_[order_[i]][c]);
      }
    const Vec3f size = high - low;
    const size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2, middle = (begin + end) / 2;
    std::nth_element(order_.begin() + std::ptrdiff_t(begin), order_.begin() + std::ptrdiff_t(middle),
                     order_.begin() + std::ptrdiff_t(end), [&](uint32_t a, uint32_t b) {
                       return points_[a][axis] != points_[b][axis] ? points_[a][axis] < points_[b][axis] : a < b;
                     });
    axis_[middle] = static_cast<uint8_t>(axis);
    build(begin, middle);
    build(middle + 1, end);
  }

  void offer(uint32_t candidate, uint32_t self, std::array<float, kNearest>& best) const {
    if (candidate == self) return;
    const float squared = squared_length(points_[candidate] - points_[self]);
    if (!(squared < best.back())) return;
    best.back() = squared;
    std::sort(best.begin(), best.end());
  }

  void search(size_t begin, size_t end, uint32_t self, std::array<float, kNearest>& best) const {
    if (end - begin <= kLeafSize) {
      for (size_t i = begin; i < end; ++i) offer(order_[i], self, best);
      return;
    }
    const size_t middle = (begin + end) / 2, axis = axis_[middle];
    const float offset = points_[self][axis] - points_[order_[middle]][axis];
    offer(order_[middle], self, best);
    const bool left_first = offset < 0;
    if (left_first)
      search(begin, middle, self, best);
    else
      search(middle + 1, end, self, best);
    if (offset * offset > best.back()) return;
    if (left_first)
      search(middle + 1, end, self, best);
    else
      search(begin, middle, self, best);
  }

  std::span<const Vec3f> points_;
  std::vector<uint32_t> order_;
  std::vector<uint8_t> axis_;
};

}  // namespace

std::vector<float> neighbour_spacing(std::span<const Vec3f> points) {
  const PointTree tree(points);
  std::vector<float> spacing(points.size(), 0.f);
  parallel_for(points.size(), 256, [&](size_t i) {
    double sum = 0;
    int count = 0;
    for (float squared : tree.nearest(static_cast<uint32_t>(i)))
      if (squared < std::numeric_limits<float>::infinity()) {
        sum += squared;
        ++count;
      }
    if (count > 0) spacing[i] = static_cast<float>(std::sqrt(sum / count));
  });
  return spacing;
}

}  // namespace vitrine
