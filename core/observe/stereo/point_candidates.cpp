#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/connected_components.h"
#include "core/foundation/math/vec.h"
#include "core/observe/stereo/plane_fit.h"
#include "core/observe/stereo/silhouette.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr double kBand = 0.035;      // of the picture's longest side: width of the band next to a mask
constexpr double kMostPhotos = 0.6;  // of those that have the point in the picture
constexpr size_t kFewestOfPlane = 3;
constexpr int kTrials = 600;                // RANSAC trials per plane
constexpr double kOnPointPlane_rel = 0.01;  // of the distance from the cameras' centre
constexpr size_t kFewestOnPlane = 8;        // inliers of a plane
constexpr size_t kMostPointPlanes = 4;
constexpr int kGridCells = 96;        // along the longer side of the grid on a plane
constexpr double kGridMargin = 0.5;   // of the extent of the plane's inliers, on each side
constexpr double kInsideShare = 0.6;  // of the photos that see a cell
constexpr size_t kFewestCells = 24;
constexpr uint64_t kPlaneSeed = 0x9a7e;

// 2 inside the mask, 1 next to it, 0 elsewhere.
std::vector<uint8_t> bands(const Silhouette& mask) {
  const int width = mask.value.width(), height = mask.value.height();
  const int reach = std::max(1, int(kBand * mask.view.intrinsics.longest_side()));
  std::vector<uint8_t> across(size_t(width) * size_t(height), 0), out(across.size(), 0);
  const auto widen = [](int count, const auto& source, const auto& target, int by) {
    int last = -by - 1;
    for (int i = 0; i < count + by; ++i) {
      if (i < count && source(i)) last = i;
      if (i - by >= 0 && last >= i - 2 * by && last >= 0) target(i - by);
    }
  };
  for (int y = 0; y < height; ++y)
    widen(
        width, [&](int x) { return mask.value.at(x, y) >= 0.5f; },
        [&](int x) { across[size_t(y) * size_t(width) + size_t(x)] = 1; }, reach);
  for (int x = 0; x < width; ++x)
    widen(
        height, [&](int y) { return across[size_t(y) * size_t(width) + size_t(x)] != 0; },
        [&](int y) { out[size_t(y) * size_t(width) + size_t(x)] = 1; }, reach);
  for (size_t i = 0; i < out.size(); ++i)
    if (mask.value.data()[i] >= 0.5f) out[i] = 2;
  return out;
}

struct WeightedPoint {
  Vec3d position;
  double weight;
};

std::vector<WeightedPoint> points_about(std::span<const Silhouette> masks, std::span<const Vec3d> points, double inside_weight) {
  std::vector<std::vector<uint8_t>> where(masks.size());
  parallel_for(masks.size(), 1, [&](size_t v) { where[v] = bands(masks[v]); });
  std::vector<WeightedPoint> out;
  for (const Vec3d& p : points) {
    size_t seen = 0, inside = 0, near_edge = 0;
    for (size_t v = 0; v < masks.size(); ++v)
      if (const auto at = image_point(p, masks[v].view)) {
        const uint8_t there = where[v][size_t(at->y) * size_t(masks[v].view.intrinsics.width) + size_t(at->x)];
        ++seen, inside += there == 2, near_edge += there == 1;
      }
    if (inside + near_edge < kFewestOfPlane || double(inside + near_edge) < kMostPhotos * double(seen)) continue;
    out.push_back({p, inside > near_edge ? inside_weight : 1});
  }
  return out;
}

struct PointPlane {
  Vec3d normal{};
  double offset = 0, weight = 0;
};

class PointPlanes {
 public:
  PointPlanes(std::vector<WeightedPoint> points, const Vec3d& eye) : points_(std::move(points)), eye_(eye) {}

  // Returns the plane with the largest inlier weight and removes its inliers.
  std::optional<std::pair<PointPlane, std::vector<Vec3d>>> next(uint64_t number) {
    if (points_.size() < kFewestOnPlane) return std::nullopt;
    std::vector<PointPlane> trials(kTrials);
    parallel_for(kTrials, 16, [&](size_t i) {
      Rng rng(kPlaneSeed, mix64(number, i));
      std::array<Vec3d, 3> p;
      for (Vec3d& q : p) q = points_[rng.below(uint32_t(points_.size()))].position;
      const Vec3d n = cross(p[1] - p[0], p[2] - p[0]);
      if (!(length(n) > 1e-9)) return;
      trials[i] = weighed({normalized(n), dot(normalized(n), p[0])});
    });
    PointPlane best = *std::ranges::max_element(trials, {}, &PointPlane::weight);
    for (int round = 0; round < 3; ++round) best = refit(best);
    std::vector<Vec3d> on;
    for (const WeightedPoint& p : points_)
      if (has(best, p.position)) on.push_back(p.position);
    if (on.size() < kFewestOnPlane) return std::nullopt;
    std::erase_if(points_, [&](const WeightedPoint& p) { return has(best, p.position); });
    if (dot(best.normal, eye_) < best.offset) best.normal = -best.normal, best.offset = -best.offset;
    return std::pair(best, std::move(on));
  }

 private:
  bool has(const PointPlane& plane, const Vec3d& p) const {
    return std::abs(dot(plane.normal, p) - plane.offset) < kOnPointPlane_rel * length(p - eye_);
  }
  PointPlane weighed(PointPlane plane) const {
    for (const WeightedPoint& p : points_)
      if (has(plane, p.position)) plane.weight += p.weight;
    return plane;
  }
  PointPlane refit(const PointPlane& plane) const {
    double sum = 0;
    Vec3d mean{};
    for (const WeightedPoint& p : points_)
      if (has(plane, p.position)) sum += p.weight, mean += p.weight * p.position;
    if (!(sum > 0)) return plane;
    mean = mean / sum;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    for (const WeightedPoint& p : points_)
      if (has(plane, p.position)) {
        const Eigen::Vector3d d(p.position.x - mean.x, p.position.y - mean.y, p.position.z - mean.z);
        scatter += p.weight * d * d.transpose();
      }
    const Eigen::Vector3d n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
    const Vec3d normal{n.x(), n.y(), n.z()};
    return weighed({normal, dot(normal, mean)});
  }

  std::vector<WeightedPoint> points_;
  Vec3d eye_;
};

// Minimum-area rectangle around points of a plane: one of its sides lies on a side of their convex hull.
Plane least_rectangle(const Vec3d& origin, const Vec3d& u, const Vec3d& v, std::vector<Vec2d> points) {
  const std::vector<Vec2d> hull = convex_hull(std::move(points));
  Plane best;
  double least = 1e300;
  for (size_t i = 0; i < hull.size(); ++i) {
    const Vec2d side = hull[(i + 1) % hull.size()] - hull[i];
    const double size = std::hypot(side.x, side.y);
    if (!(size > 0)) continue;
    const Vec2d along{side.x / size, side.y / size};
    Vec2d low{1e300, 1e300}, high{-1e300, -1e300};
    for (const Vec2d& p : hull) {
      const Vec2d q{along.x * p.x + along.y * p.y, along.x * p.y - along.y * p.x};
      for (size_t c = 0; c < 2; ++c) low[c] = std::min(low[c], q[c]), high[c] = std::max(high[c], q[c]);
    }
    const Vec2d extent = high - low;
    if (extent.x * extent.y >= least) continue;
    least = extent.x * extent.y;
    const Vec3d x = along.x * u + along.y * v, y = along.x * v - along.y * u;
    best = {origin + 0.5 * (low.x + high.x) * x + 0.5 * (low.y + high.y) * y, Mat3d{x, y, cross(x, y)}, 0.5 * extent};
  }
  return best;
}

std::vector<Plane> rectangles_on(const PointPlane& plane, std::span<const Vec3d> on, std::span<const Silhouette> masks) {
  const auto [u, v] = orthonormal_basis(plane.normal);
  const Vec3d origin = plane.offset * plane.normal;
  Vec2d low{1e300, 1e300}, high{-1e300, -1e300};
  for (const Vec3d& p : on) {
    low = {std::min(low.x, dot(u, p)), std::min(low.y, dot(v, p))};
    high = {std::max(high.x, dot(u, p)), std::max(high.y, dot(v, p))};
  }
  const double longest = std::max(high.x - low.x, high.y - low.y), margin = kGridMargin * longest;
  const double cell = (longest + 2 * margin) / kGridCells;
  const int width = int((high.x - low.x + 2 * margin) / cell) + 1, height = int((high.y - low.y + 2 * margin) / cell) + 1;
  const auto place = [&](double x, double y) {
    return origin + (low.x - margin + cell * x) * u + (low.y - margin + cell * y) * v;
  };
  std::vector<uint8_t> inside(size_t(width) * size_t(height), 0);
  parallel_for(inside.size(), 256, [&](size_t i) {
    const Vec3d p = place(double(i % size_t(width)) + 0.5, double(i / size_t(width)) + 0.5);
    size_t look = 0, marked = 0;
    for (const Silhouette& mask : masks) {
      if (!(dot(mask.view.centre_in_world() - p, plane.normal) > 0)) continue;
      const auto at = image_point(p, mask.view);
      if (!at) continue;
      const float value = mask.value.at(int(at->x), int(at->y));
      look += value >= 0, marked += value >= 0.5f;
    }
    inside[i] = marked >= kFewestOfPlane && double(marked) >= kInsideShare * double(look);
  });
  const ConnectedComponents parts = connected_components(
      inside.size(), [&](size_t i) { return inside[i] != 0; },
      [&](size_t i, const auto& visit) {
        const auto row = size_t(width);
        if (i % row > 0) visit(i - 1);
        if (i % row + 1 < row) visit(i + 1);
        if (i >= row) visit(i - row);
        if (i + row < inside.size()) visit(i + row);
      });
  std::vector<Plane> out;
  for (const std::vector<size_t>& part : parts.members) {
    if (part.size() < kFewestCells) continue;
    std::vector<Vec2d> ends;
    for (const size_t i : part)
      for (const double x : {0.0, 1.0})
        for (const double y : {0.0, 1.0})
          ends.push_back(
              {low.x - margin + cell * (double(i % size_t(width)) + x), low.y - margin + cell * (double(i / size_t(width)) + y)});
    const Plane found = least_rectangle(origin, u, v, std::move(ends));
    if (found.half.x > 0 && found.half.y > 0) out.push_back(found);
  }
  return out;
}

}  // namespace

std::vector<Plane> candidates_of_points(std::span<const Silhouette> masks, std::span<const Vec3d> points, double inside_weight) {
  Vec3d eye{};
  for (const Silhouette& mask : masks) eye += mask.view.centre_in_world() / double(masks.size());
  PointPlanes planes(points_about(masks, points, inside_weight), eye);
  std::vector<Plane> out;
  for (size_t i = 0; i < kMostPointPlanes; ++i) {
    const auto found = planes.next(i);
    if (!found) break;
    const std::vector<Plane> on = rectangles_on(found->first, found->second, masks);
    out.insert(out.end(), on.begin(), on.end());
  }
  return out;
}

}  // namespace vitrine
