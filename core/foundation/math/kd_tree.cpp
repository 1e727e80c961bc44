#include "core/foundation/math/kd_tree.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {
constexpr size_t kLeafSize = 8;
}

template <class T>
struct KdTree<T>::Query {
  const Vec3<T>& p;
  size_t count;
  T squared_radius;
  uint32_t self;
  std::vector<Near>& heap;  // max-heap: farthest first

  // Farther points are rejected.
  T limit() const { return heap.size() < count ? squared_radius : heap.front().squared_distance; }
};

template <class T>
KdTree<T>::KdTree(std::span<const Vec3<T>> points) : points_(points) {
  order_.reserve(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].x) && std::isfinite(points[i].y) && std::isfinite(points[i].z))
      order_.push_back(static_cast<uint32_t>(i));
  axis_.resize(order_.size());
  build(0, order_.size());
}

template <class T>
void KdTree<T>::build(size_t begin, size_t end) {
  if (end - begin <= kLeafSize) return;
  Vec3<T> low = points_[order_[begin]], high = low;
  for (size_t i = begin; i < end; ++i)
    for (size_t c = 0; c < 3; ++c) {
      low[c] = std::min(low[c], points_[order_[i]][c]);
      high[c] = std::max(high[c], points_[order_[i]][c]);
    }
  const Vec3<T> size = high - low;
  const size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2, middle = begin + (end - begin) / 2;
  const auto at = [&](size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end), [&](uint32_t a, uint32_t b) {
    const T pa = points_[a][axis], pb = points_[b][axis];
    return pa != pb ? pa < pb : a < b;
  });
  axis_[middle] = static_cast<uint8_t>(axis);
  build(begin, middle);
  build(middle + 1, end);
}

template <class T>
void KdTree<T>::search(const Vec3<T>& p, size_t count, T radius, uint32_t self, std::vector<Near>& out) const {
  out.clear();
  if (count == 0) return;
  Query query{p, count, radius * radius, self, out};
  visit(0, order_.size(), query);
  std::sort_heap(out.begin(), out.end());
}

template <class T>
void KdTree<T>::visit(size_t begin, size_t end, Query& query) const {
  const auto offer = [&](uint32_t i) {
    if (i == query.self) return;
    const Near near{squared_length(points_[i] - query.p), i};
    if (!(near.squared_distance <= query.limit())) return;
    query.heap.push_back(near);
    std::push_heap(query.heap.begin(), query.heap.end());
    if (query.heap.size() <= query.count) return;
    std::pop_heap(query.heap.begin(), query.heap.end());
    query.heap.pop_back();
  };
  if (end - begin <= kLeafSize) {
    for (size_t i = begin; i < end; ++i) offer(order_[i]);
    return;
  }
  const size_t middle = begin + (end - begin) / 2, axis = axis_[middle];
  const T offset = query.p[axis] - points_[order_[middle]][axis];
  offer(order_[middle]);
  const bool low = offset < 0;
  visit(low ? begin : middle + 1, low ? middle : end, query);
  if (offset * offset <= query.limit()) visit(low ? middle + 1 : begin, low ? end : middle, query);
}

template <class T>
bool KdTree<T>::any(const Vec3<T>& p, T radius) const {
  thread_local std::vector<Near> found;
  nearest(p, 1, radius, found);
  return !found.empty();
}

template class KdTree<float>;
template class KdTree<double>;

}  // namespace vitrine
