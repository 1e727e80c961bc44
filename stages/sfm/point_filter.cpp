#include "stages/sfm/point_filter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "core/base/error.h"
#include "core/base/parallel.h"
#include "core/camera/compacted.h"
#include "core/math/median.h"
#include "stages/sfm/sfm.h"

namespace vitrine {

namespace {

// Static k-d tree over indices: the median of a range sits in its middle.
class KdTree {
 public:
  explicit KdTree(std::span<const Vec3d> points) : points_(points), order_(points.size()), axis_(points.size()) {
    std::iota(order_.begin(), order_.end(), uint32_t{0});
    build(0, order_.size());
  }

  // The k nearest other points, ascending: squared distance, index.
  using Near = std::pair<double, uint32_t>;
  std::vector<Near> nearest(uint32_t query, size_t k) const {
    std::vector<Near> heap;
    search(0, order_.size(), query, k, heap);
    std::sort_heap(heap.begin(), heap.end());
    return heap;
  }

 private:
  void build(size_t begin, size_t end) {
    if (end - begin < 2) return;
    Bounds3 box;
    for (size_t i = begin; i < end; ++i) box.extend(points_[order_[i]]);
    const Vec3d size = box.high - box.low;
    const uint8_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const size_t middle = begin + (end - begin) / 2;
    std::nth_element(order_.begin() + long(begin), order_.begin() + long(middle), order_.begin() + long(end),
                     [&](uint32_t a, uint32_t b) { return std::pair(points_[a][axis], a) < std::pair(points_[b][axis], b); });
    axis_[middle] = axis;
    build(begin, middle);
    build(middle + 1, end);
  }

  void search(size_t begin, size_t end, uint32_t query, size_t k, std::vector<Near>& heap) const {
    if (begin >= end) return;
    const size_t middle = begin + (end - begin) / 2;
    const uint32_t here = order_[middle];
    if (here != query) {
      heap.push_back({squared_length(points_[here] - points_[query]), here});
      std::push_heap(heap.begin(), heap.end());
      if (heap.size() > k) {
        std::pop_heap(heap.begin(), heap.end());
        heap.pop_back();
      }
    }
    const double side = points_[query][axis_[middle]] - points_[here][axis_[middle]];
    const bool low = side < 0;
    search(low ? begin : middle + 1, low ? middle : end, query, k, heap);
    if (heap.size() < k || side * side <= heap.front().first)
      search(low ? middle + 1 : begin, low ? end : middle, query, k, heap);
  }

  std::span<const Vec3d> points_;
  std::vector<uint32_t> order_;
  std::vector<uint8_t> axis_;
};

}  // namespace

std::vector<double> neighbour_distances(std::span<const Vec3d> points, size_t k) {
  std::vector<double> out(points.size(), 0);
  const KdTree tree(points);
  parallel_for(points.size(), 256, [&](size_t i) {
    const std::vector<KdTree::Near> near = tree.nearest(static_cast<uint32_t>(i), k);
    for (const auto& [squared, index] : near) out[i] += std::sqrt(squared) / double(near.size());
  });
  return out;
}

std::vector<std::vector<uint32_t>> neighbours(std::span<const Vec3d> points, size_t k) {
  std::vector<std::vector<uint32_t>> out(points.size());
  const KdTree tree(points);
  parallel_for(points.size(), 256, [&](size_t i) {
    for (const auto& [squared, index] : tree.nearest(static_cast<uint32_t>(i), k)) out[i].push_back(index);
  });
  return out;
}

double triangulation_angle(const ColmapPoint3D& point, const std::vector<Vec3d>& centres) {
  double smallest_cosine = 1;
  for (size_t i = 0; i < centres.size(); ++i)
    for (size_t j = i + 1; j < centres.size(); ++j) {
      const Vec3d a = centres[i] - point.position, b = centres[j] - point.position;
      smallest_cosine = std::min(smallest_cosine, dot(a, b) / std::max(1e-300, length(a) * length(b)));
    }
  return std::acos(std::clamp(smallest_cosine, -1.0, 1.0));
}

ColmapModel filtered(const ColmapModel& model, const SfmFilterConfig& config, FilterCounts& counts) {
  counts = {.before = model.points.size()};
  std::map<uint32_t, Rigid> pose;
  for (const ColmapImage& image : model.images) pose[image.id] = image.cam_from_world();
  std::map<uint64_t, bool> good;
  const double min_angle = config.min_angle_deg * std::numbers::pi / 180;
  for (const ColmapPoint3D& p : model.points) {
    std::vector<Vec3d> centres;
    bool behind = false;
    for (const ColmapTrackElement& t : p.track) {
      const Rigid& cam_from_world = pose.at(t.image_id);
      behind |= (cam_from_world * p.position).z <= 0;
      centres.push_back(inverse(cam_from_world).translation);
    }
    const bool large_error = p.error_px > config.max_error_px, few = p.track.size() < size_t(config.min_views);
    const bool small = triangulation_angle(p, centres) < min_angle;
    counts.large_error += large_error;
    counts.few_views += !large_error && few;
    counts.behind += !large_error && !few && behind;
    counts.small_angle += !large_error && !few && !behind && small;
    good[p.id] = !large_error && !few && !behind && !small;
  }
  // Lonely points: distances to neighbours spread over orders of magnitude (near object, far walls), hence logarithms, and
  // median and MAD instead of mean and deviation.
  constexpr size_t kNeighbours = 8;
  std::vector<Vec3d> positions;
  std::vector<uint64_t> ids;
  for (const ColmapPoint3D& p : model.points)
    if (good[p.id]) positions.push_back(p.position), ids.push_back(p.id);
  if (positions.size() > 4 * kNeighbours && config.outlier_sigma > 0) {
    const std::vector<double> distances = neighbour_distances(positions, kNeighbours);
    std::vector<double> logs(distances.size());
    for (size_t i = 0; i < logs.size(); ++i) logs[i] = std::log(std::max(distances[i], 1e-300));
    const double centre = upper_median(logs);
    std::vector<double> deviations(logs.size());
    for (size_t i = 0; i < logs.size(); ++i) deviations[i] = std::abs(logs[i] - centre);
    const double limit = centre + config.outlier_sigma * kSigmaPerDeviation * upper_median(deviations);
    for (size_t i = 0; i < logs.size(); ++i)
      if (logs[i] > limit) good[ids[i]] = false, ++counts.lonely;
  }
  ColmapModel out = compacted(model, [&](const ColmapPoint3D& p) { return good.at(p.id); });
  counts.after = out.points.size();
  return out;
}

}  // namespace vitrine
