#include "stages/sfm/point_filter.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/kd_tree.h"
#include "core/foundation/math/median.h"
#include "core/intake/poses/colmap_repair.h"

namespace vitrine {

namespace {

constexpr double kMaxErrorPx = 2;                           // mean reprojection error of a point
constexpr double kMinAngle = 1.5 * std::numbers::pi / 180;  // between two rays to a point
constexpr size_t kMinViews = 2;                             // photos that see a point
constexpr double kOutlierSigma = 3;                         // robust deviations of the distance to the neighbours

}  // namespace

std::vector<double> neighbour_distances(std::span<const Vec3d> points, size_t k) {
  std::vector<double> out(points.size(), 0);
  const KdTreed tree(points);
  parallel_for(points.size(), 256, [&](size_t i) {
    std::vector<KdTreed::Near> near;
    tree.nearest_others(static_cast<uint32_t>(i), k, near);
    for (const auto& [squared, index] : near) out[i] += std::sqrt(squared) / double(near.size());
  });
  return out;
}

std::vector<std::vector<uint32_t>> neighbours(std::span<const Vec3d> points, size_t k) {
  std::vector<std::vector<uint32_t>> out(points.size());
  const KdTreed tree(points);
  parallel_for(points.size(), 256, [&](size_t i) {
    std::vector<KdTreed::Near> near;
    tree.nearest_others(static_cast<uint32_t>(i), k, near);
    for (const auto& [squared, index] : near) out[i].push_back(index);
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

ColmapModel filtered(const ColmapModel& model, FilterCounts& counts) {
  counts = {.before = model.points.size()};
  std::map<uint32_t, Rigid> pose;
  for (const ColmapImage& image : model.images) pose[image.id] = image.cam_from_world();
  std::map<uint64_t, bool> good;
  for (const ColmapPoint3D& p : model.points) {
    std::vector<Vec3d> centres;
    bool behind = false;
    for (const ColmapTrackElement& t : p.track) {
      const Rigid& cam_from_world = pose.at(t.image_id);
      behind |= (cam_from_world * p.position).z <= 0;
      centres.push_back(inverse(cam_from_world).translation);
    }
    const bool large_error = p.error_px > kMaxErrorPx, few = p.track.size() < kMinViews;
    const bool small = triangulation_angle(p, centres) < kMinAngle;
    counts.large_error += large_error;
    counts.few_views += !large_error && few;
    counts.behind += !large_error && !few && behind;
    counts.small_angle += !large_error && !few && !behind && small;
    good[p.id] = !large_error && !few && !behind && !small;
  }
  // Isolated points: distances to neighbours range over orders of magnitude (near object, far walls), hence logarithms, and
  // median and MAD instead of mean and deviation.
  constexpr size_t kNeighbours = 8;
  std::vector<Vec3d> positions;
  std::vector<uint64_t> ids;
  for (const ColmapPoint3D& p : model.points)
    if (good[p.id]) positions.push_back(p.position), ids.push_back(p.id);
  if (positions.size() > 4 * kNeighbours) {
    const std::vector<double> distances = neighbour_distances(positions, kNeighbours);
    std::vector<double> logs(distances.size());
    for (size_t i = 0; i < logs.size(); ++i) logs[i] = std::log(std::max(distances[i], 1e-300));
    const double centre = upper_median(logs);
    std::vector<double> deviations(logs.size());
    for (size_t i = 0; i < logs.size(); ++i) deviations[i] = std::abs(logs[i] - centre);
    const double limit = centre + kOutlierSigma * kSigmaPerDeviation * upper_median(deviations);
    for (size_t i = 0; i < logs.size(); ++i)
      if (logs[i] > limit) good[ids[i]] = false, ++counts.lonely;
  }
  ColmapModel out = compacted(model, [&](const ColmapPoint3D& p) { return good.at(p.id); });
  counts.after = out.points.size();
  return out;
}

}  // namespace vitrine
