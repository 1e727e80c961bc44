#include "core/observe/stereo/scene_planes.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Dense>

#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

constexpr int kPointStep = 4, kCandidateStep = 12;  // sampling step in pixels
constexpr double kOnPlane = 0.012;                  // maximum distance of an inlier, relative to its depth
constexpr double kTurned = 0.8;                     // minimum cosine between the normals of an inlier and the plane
constexpr size_t kMostPlanes = 12;
constexpr double kLeastShare = 0.01;
constexpr double kLevel = 0.94;        // cosine between a floor's normal and up (+z)
constexpr double kBelowFloor = 0.005;  // share of all samples below a floor: stereo errors

struct Sample {
  Vec3d position, normal;
  double depth, weight;
};

bool lies_on(const Sample& s, const ScenePlane& plane) {
  return std::abs(dot(plane.normal, s.position) - plane.offset) < kOnPlane * s.depth &&
         std::abs(dot(plane.normal, s.normal)) > kTurned;
}

double support(const std::vector<Sample>& samples, const ScenePlane& plane) {
  double sum = 0;
  for (const Sample& s : samples)
    if (lies_on(s, plane)) sum += s.weight;
  return sum;
}

// Least squares over the inliers, with distances relative to the depth.
ScenePlane refined(const std::vector<Sample>& samples, const ScenePlane& plane) {
  double sum = 0;
  Vec3d mean{};
  for (const Sample& s : samples)
    if (lies_on(s, plane)) {
      const double w = s.weight / (s.depth * s.depth);
      sum += w, mean += w * s.position;
    }
  if (!(sum > 0)) return plane;
  mean = mean / sum;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const Sample& s : samples)
    if (lies_on(s, plane)) {
      const Vec3d d = s.position - mean;
      const Eigen::Vector3d e(d.x, d.y, d.z);
      scatter += (s.weight / (s.depth * s.depth)) * e * e.transpose();
    }
  const Eigen::Vector3d normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  ScenePlane better = plane;
  better.normal = {normal.x(), normal.y(), normal.z()};
  better.offset = dot(better.normal, mean);
  return better;
}

void measure(const std::vector<Sample>& samples, ScenePlane& plane) {
  double sum = 0, squares = 0;
  Vec3d mean{};
  for (const Sample& s : samples)
    if (lies_on(s, plane)) sum += s.weight, mean += s.weight * s.position;
  if (!(sum > 0)) return;
  plane.centre = mean / sum;
  for (const Sample& s : samples)
    if (lies_on(s, plane)) squares += s.weight * dot(s.position - plane.centre, s.position - plane.centre);
  plane.extent = std::sqrt(squares / sum);
}

bool is_floor(const ScenePlane& plane, std::span<const StereoPhoto> photos, std::span<const DepthMap> maps,
              const std::vector<Sample>& samples) {
  if (std::abs(plane.normal.z) < kLevel) return false;
  const double up = plane.normal.z > 0 ? 1 : -1;
  const auto height = [&](const Vec3d& p) { return up * (dot(plane.normal, p) - plane.offset); };
  for (size_t v = 0; v < maps.size(); ++v)
    if (!maps[v].zdepth.empty() && !(height(photos[v].view.centre_in_world()) > 0)) return false;
  double below = 0, all = 0;
  for (const Sample& s : samples) {
    all += s.weight;
    if (height(s.position) < -2 * kOnPlane * s.depth) below += s.weight;
  }
  return below < kBelowFloor * all;
}

}  // namespace

std::vector<ScenePlane> scene_planes(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps) {
  std::vector<Sample> samples;
  std::vector<ScenePlane> candidates;
  double total = 0;
  for (size_t v = 0; v < maps.size(); ++v) {
    const DepthMap& map = maps[v];
    if (map.zdepth.empty()) continue;
    const Intrinsics& k = photos[v].view.intrinsics;
    const Rigid world_from_cam = inverse(photos[v].view.cam_from_world);
    for (int y = kPointStep / 2; y < map.height; y += kPointStep)
      for (int x = kPointStep / 2; x < map.width; x += kPointStep) {
        const size_t i = map.index(x, y);
        if (!map.reliable(i)) continue;
        const double z = double(map.zdepth[i]);
        // A surface that many photos see has a sample in each of them: each gets a smaller weight.
        samples.push_back({world_from_cam * (z * k.ray(x + 0.5, y + 0.5)), world_from_cam.rotation * cast<double>(map.normal[i]),
                           z, 1.0 / (1 + map.agreeing[i])});
        total += samples.back().weight;
      }
    for (int y = kCandidateStep / 2; y < map.height; y += kCandidateStep)
      for (int x = kCandidateStep / 2; x < map.width; x += kCandidateStep) {
        if (!map.reliable(map.index(x, y))) continue;
        const InversePlane plane = fitted_plane(k, map, x, y);
        const Vec3d normal = world_from_cam.rotation * normal_towards_camera(k, plane);
        const Vec3d point = world_from_cam * (k.ray(x + 0.5, y + 0.5) / plane.at(x + 0.5, y + 0.5));
        candidates.push_back({normal, dot(normal, point), 0});
      }
  }
  const std::vector<Sample> all = samples;
  std::vector<ScenePlane> planes;
  while (planes.size() < kMostPlanes && !candidates.empty()) {
    parallel_for(candidates.size(), 64, [&](size_t c) { candidates[c].share = support(samples, candidates[c]); });
    ScenePlane best = *std::max_element(candidates.begin(), candidates.end(),
                                        [](const ScenePlane& a, const ScenePlane& b) { return a.share < b.share; });
    for (int round = 0; round < 3; ++round) best = refined(samples, best);
    best.share = support(samples, best) / total;
    if (!(best.share >= kLeastShare)) break;
    best.floor = is_floor(best, photos, maps, all);
    measure(samples, best);
    planes.push_back(best);
    std::erase_if(samples, [&](const Sample& s) { return lies_on(s, best); });
    std::erase_if(candidates, [&](const ScenePlane& c) { return c.share < kLeastShare * total; });
  }
  return planes;
}

namespace {

constexpr int kFitRadius = 10;       // pixels
constexpr double kSamePlane = 0.02;  // maximum relative difference of inverse depth for an inlier

}  // namespace

InversePlane inverse_plane(const Intrinsics& k, const Vec3d& n, double offset) {
  return {n.x / k.fx / offset, n.y / k.fy / offset, (n.z - n.x * k.cx / k.fx - n.y * k.cy / k.fy) / offset};
}

Vec3d normal_towards_camera(const Intrinsics& k, const InversePlane& plane) {
  // The gradient of the inverse depth is n/d along the ray: positive in front of the camera, so the normal towards it is the
  // negative.
  return -normalized(Vec3d{plane.a * k.fx, plane.b * k.fy, plane.c + plane.a * k.cx + plane.b * k.cy});
}

InversePlane fitted_plane(const Intrinsics& k, const DepthMap& map, int x, int y) {
  const size_t centre = map.index(x, y);
  const Vec3d n = cast<double>(map.normal[centre]);
  InversePlane plane = inverse_plane(k, n, double(map.zdepth[centre]) * dot(n, k.ray(x + 0.5, y + 0.5)));
  for (int round = 0; round < 2; ++round) {
    double count = 0, sx = 0, sy = 0, sw = 0, sxx = 0, sxy = 0, syy = 0, sxw = 0, syw = 0;
    for (int v = std::max(0, y - kFitRadius); v <= std::min(map.height - 1, y + kFitRadius); ++v)
      for (int u = std::max(0, x - kFitRadius); u <= std::min(map.width - 1, x + kFitRadius); ++u) {
        const size_t i = map.index(u, v);
        if (!map.reliable(i)) continue;
        const double w = 1 / double(map.zdepth[i]), expected = plane.at(u + 0.5, v + 0.5);
        if (!(std::abs(w - expected) < kSamePlane * w)) continue;
        const double du = u - x, dv = v - y;
        count += 1, sx += du, sy += dv, sw += w, sxx += du * du, sxy += du * dv, syy += dv * dv, sxw += du * w, syw += dv * w;
      }
    if (count < 12) break;
    const double mx = sx / count, my = sy / count, mw = sw / count;
    const double xx = sxx / count - mx * mx, xy = sxy / count - mx * my, yy = syy / count - my * my;
    const double determinant = xx * yy - xy * xy;
    if (!(determinant > 0.05 * xx * yy) || !(xx > 1) || !(yy > 1)) break;  // a strip of pixels leaves the plane underdetermined
    const double xw = sxw / count - mx * mw, yw = syw / count - my * mw;
    plane.a = (xw * yy - yw * xy) / determinant;
    plane.b = (yw * xx - xw * xy) / determinant;
    plane.c = mw - plane.a * (mx + x + 0.5) - plane.b * (my + y + 0.5);
  }
  return plane;
}

}  // namespace vitrine
