#include "stages/optimize/moving_evidence.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/quantile.h"
#include "core/foundation/math/vec.h"
#include "core/scene/camera/projection.h"

namespace vitrine {

namespace {

constexpr size_t kMostPoints = 150000;
constexpr size_t kFewestPhotos = 3;
constexpr double kMostAgainst = 0.2;  // of the photos with evidence at the position
constexpr double kSameDepth = 0.05;   // of the depth
constexpr double kNearPlane = 0.012;  // of the cameras' distance, as for scene_planes()
constexpr double kTurned = 0.8;       // cosine between normals
constexpr size_t kFewestOnPlane = 30;
constexpr double kLeastOfPoints = 0.25;  // share of the points on a plate or table plane
constexpr double kTrim = 0.01;           // of the points of a plane: outliers at either end, in each of 32 directions
constexpr size_t kDirections = 32;
constexpr double kLargestSplat = 6;  // pixels: a larger splat indicates a wrong point
constexpr int kBorder = 2;           // pixels: neighbouring texture may explain a patch

// Votes of the photos for a position.
struct Votes {
  size_t still = 0, against = 0, silent = 0;
  size_t plain = 0;  // of the silent ones: a backdrop, where a textured point would be visible
};

Votes votes_at(const Capture& capture, const DenseDepth& dense, const MovingEvidence& evidence, const Vec3d& position) {
  Votes votes;
  for (uint32_t v : capture.train) {
    const PhotoEvidence& of = evidence.photos[v];
    if (of.pixels.empty()) continue;
    const auto p = image_point(position, dense.photos[v].view);
    if (!p) continue;
    const DepthMap& map = dense.maps[v];
    const size_t pixel = map.index(int(p->x), int(p->y));
    const double depth = map.reliable(pixel) ? double(map.zdepth[pixel]) : 0;
    const bool looks_through = depth > (1 + kSameDepth) * p->z;
    if (depth > 0 && depth < (1 - kSameDepth) * p->z) continue;  // occluded
    if (of.pixels[pixel] == Evidence::Object && !looks_through) continue;
    if (looks_through || of.pixels[pixel] == Evidence::Moves)
      ++votes.against;
    else if (depth > 0)
      ++votes.still;
    else
      ++votes.silent, votes.plain += of.plain[pixel];
  }
  return votes;
}

bool uncontradicted(const Votes& votes) {
  return double(votes.against) <= kMostAgainst * double(votes.against + votes.still + votes.silent);
}

// Subsampled pixels that stereo explains.
std::vector<StillPoint> explained(const Capture& capture, const DenseDepth& dense, const MovingEvidence& evidence) {
  size_t all = 0;
  const auto counts = [&](uint32_t v, size_t i) {
    const PhotoEvidence& of = evidence.photos[v];
    return of.pixels[i] == Evidence::Still && of.fine[i] && dense.maps[v].reliable(i);
  };
  for (uint32_t v : capture.train)
    for (size_t i = 0; i < evidence.photos[v].pixels.size(); ++i) all += counts(v, i);
  const auto step = std::max(1, int(std::ceil(std::sqrt(double(all) / double(kMostPoints)))));
  std::vector<std::vector<StillPoint>> of_photo(capture.train.size());
  parallel_for(capture.train.size(), 1, [&](size_t t) {
    throw_if_interrupted();
    const uint32_t v = capture.train[t];
    if (evidence.photos[v].pixels.empty()) return;
    const Intrinsics& k = dense.photos[v].view.intrinsics;
    const DepthMap& map = dense.maps[v];
    const Rigid world_from_cam = inverse(dense.photos[v].view.cam_from_world);
    for (int y = 0; y < map.height; y += step)
      for (int x = 0; x < map.width; x += step) {
        const size_t i = map.index(x, y);
        if (!counts(v, i)) continue;
        const double z = double(map.zdepth[i]);
        const Vec3d position = world_from_cam * (z * k.ray(x + 0.5, y + 0.5));
        const Votes votes = votes_at(capture, dense, evidence, position);
        const size_t against = votes.against + votes.plain;
        if (votes.still >= kFewestPhotos && double(against) <= kMostAgainst * double(against + votes.still))
          of_photo[t].push_back({position, world_from_cam.rotation * cast<double>(map.normal[i]), 0.75 * step * z / k.fx});
      }
  });
  std::vector<StillPoint> points;
  for (const auto& list : of_photo) points.insert(points.end(), list.begin(), list.end());
  return points;
}

// Convex region of the points on a plane: coordinates below `most[d]` in each of the directions d.
struct PlanePatch {
  Vec3d u, v;
  std::array<Vec3d, kDirections> directions;
  std::array<double, kDirections> most;

  bool contains(const Vec3d& position) const {
    for (size_t d = 0; d < kDirections; ++d)
      if (dot(directions[d], position) > most[d]) return false;
    return true;
  }
};

PlanePatch patch_of(const ScenePlane& plane, const std::vector<StillPoint>& on_plane) {
  PlanePatch patch;
  const auto across = orthonormal_basis(plane.normal);
  patch.u = across.u, patch.v = across.v;
  std::vector<double> reach(on_plane.size());
  for (size_t d = 0; d < kDirections; ++d) {
    const double angle = 2 * std::numbers::pi * double(d) / kDirections;
    patch.directions[d] = std::cos(angle) * patch.u + std::sin(angle) * patch.v;
    for (size_t i = 0; i < on_plane.size(); ++i) reach[i] = dot(patch.directions[d], on_plane[i].position);
    patch.most[d] = quantile_of(reach, 1 - kTrim);
  }
  return patch;
}

// Adds points on the plane between the explained points unless photos contradict them.
void add_between(const Capture& capture, const DenseDepth& dense, const MovingEvidence& evidence, const ScenePlane& plane,
                 std::span<const StillPoint> explained_points, std::vector<StillPoint>& points) {
  double distance = 0;
  for (uint32_t v : capture.train) distance += length(dense.photos[v].view.centre_in_world() - plane.centre);
  distance /= double(capture.train.size());
  std::vector<StillPoint> on_plane;
  for (const StillPoint& p : explained_points)
    if (std::abs(dot(plane.normal, p.position) - plane.offset) < kNearPlane * distance &&
        std::abs(dot(plane.normal, p.normal)) > kTurned)
      on_plane.push_back(p);
  if (on_plane.size() < kFewestOnPlane || double(on_plane.size()) < kLeastOfPoints * double(explained_points.size())) return;
  std::vector<double> radii;
  for (const StillPoint& p : on_plane) radii.push_back(p.radius);
  const PlanePatch patch = patch_of(plane, on_plane);
  const Vec3d origin = plane.offset * plane.normal;
  const double from_u = -patch.most[kDirections / 2], to_u = patch.most[0], from_v = -patch.most[3 * kDirections / 4],
               to_v = patch.most[kDirections / 4];
  const double radius = std::max(upper_median_of(std::span(radii)),
                                 std::sqrt(std::max(0.0, (to_u - from_u) * (to_v - from_v)) / double(kMostPoints)));
  const auto rows = size_t(std::max(0.0, (to_v - from_v) / radius)), columns = size_t(std::max(0.0, (to_u - from_u) / radius));
  std::vector<std::vector<StillPoint>> of_row(rows);
  parallel_for(rows, 1, [&](size_t r) {
    throw_if_interrupted();
    for (size_t c = 0; c < columns; ++c) {
      const Vec3d position =
          origin + (from_u + (double(c) + 0.5) * radius) * patch.u + (from_v + (double(r) + 0.5) * radius) * patch.v;
      if (!patch.contains(position)) continue;
      if (uncontradicted(votes_at(capture, dense, evidence, position))) of_row[r].push_back({position, plane.normal, radius});
    }
  });
  for (const auto& row : of_row) points.insert(points.end(), row.begin(), row.end());
}

// Dilates (`grow`) or erodes the mask by `by` pixels.
std::vector<uint8_t> moved_rim(const std::vector<uint8_t>& marked, int width, int height, int by, bool grow) {
  std::vector<uint8_t> result(marked.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      bool any = false;
      for (int v = std::max(0, y - by); v <= std::min(height - 1, y + by) && !any; ++v)
        for (int u = std::max(0, x - by); u <= std::min(width - 1, x + by) && !any; ++u)
          any = (marked[size_t(v) * size_t(width) + size_t(u)] != 0) == grow;
      result[size_t(y) * size_t(width) + size_t(x)] = any == grow;
    }
  return result;
}

}  // namespace

std::vector<StillPoint> still_points(const Capture& capture, const DenseDepth& dense, const MovingEvidence& evidence) {
  const std::vector<StillPoint> found = explained(capture, dense, evidence);
  std::vector<StillPoint> points = found;
  for (const ScenePlane& plane : dense.planes) add_between(capture, dense, evidence, plane, found, points);
  return points;
}

std::vector<uint8_t> shown(const View& view, std::span<const StillPoint> points, std::span<const uint8_t> object,
                           const PhotoEvidence& evidence) {
  const Intrinsics& k = view.intrinsics;
  std::vector<uint8_t> hit(k.pixel_count(), 0);
  for (const StillPoint& point : points) {
    const auto p = projection(point.position, view);
    if (!p) continue;
    const double r = std::min(std::max(0.5, k.fx * point.radius / p->z), kLargestSplat);
    const int left = std::max(0, int(std::floor(p->x - r))), right = std::min(k.width - 1, int(std::floor(p->x + r)));
    const int top = std::max(0, int(std::floor(p->y - r))), bottom = std::min(k.height - 1, int(std::floor(p->y + r)));
    for (int v = top; v <= bottom; ++v)
      for (int u = left; u <= right; ++u) hit[size_t(v) * size_t(k.width) + size_t(u)] = 1;
  }
  hit = moved_rim(moved_rim(hit, k.width, k.height, 1, true), k.width, k.height, 1, false);  // closes pinholes
  for (size_t i = 0; i < evidence.pixels.size(); ++i)
    if (evidence.pixels[i] == Evidence::Moves) hit[i] = 0;
  // The boundary is that of the union with the object; between both there is none.
  std::vector<uint8_t> both = hit;
  for (size_t i = 0; i < object.size(); ++i) both[i] |= object[i] >= 128;
  const std::vector<uint8_t> inner = moved_rim(both, k.width, k.height, kBorder, false),
                             outer = moved_rim(hit, k.width, k.height, kBorder, true);
  std::vector<uint8_t> result(hit.size(), 0);
  for (size_t i = 0; i < result.size(); ++i) result[i] = hit[i] && inner[i] ? 255 : outer[i] ? 128 : 0;
  return result;
}

}  // namespace vitrine
