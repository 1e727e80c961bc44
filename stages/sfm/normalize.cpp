#include "stages/sfm/normalize.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/foundation/base/error.h"
#include "core/foundation/math/median.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

// Length of a mean of unit vectors above which the directions count as parallel: about 25 degrees of spread.
constexpr double kParallel = 0.9;
// Thickness over width of the camera ring below which its plane normal is more precise than the cameras' roll.
constexpr double kFlatRing = 0.03;
constexpr double kRingTilt = 0.966;  // cos 15 degrees: beyond it the path is a staircase or a slope, not a level ring

Eigen::Vector3d eigen(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3d ours(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

struct Cameras {
  std::vector<Vec3d> centres, right, up, forward;
  Vec3d mean_up{}, mean_forward{}, centroid{};
};

Cameras cameras_of(const ColmapModel& model) {
  Cameras c;
  for (const ColmapImage& image : model.images) {
    const Rigid world_from_cam = inverse(image.cam_from_world());
    c.centres.push_back(world_from_cam.translation);
    c.right.push_back(world_from_cam.rotation.c0);
    c.up.push_back(-world_from_cam.rotation.c1);
    c.forward.push_back(world_from_cam.rotation.c2);
  }
  const double n = double(c.centres.size());
  for (size_t i = 0; i < c.centres.size(); ++i) {
    c.mean_up += c.up[i] / n;
    c.mean_forward += c.forward[i] / n;
    c.centroid += c.centres[i] / n;
  }
  return c;
}

struct Spread {
  Eigen::Vector3d values;  // standard deviations, ascending
  Eigen::Matrix3d directions;
};

Spread spread_of(const std::vector<Vec3d>& points, const Vec3d& centre) {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  for (const Vec3d& p : points) m += eigen(p - centre) * eigen(p - centre).transpose() / double(points.size());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m);
  return {solver.eigenvalues().cwiseMax(0).cwiseSqrt(), solver.eigenvectors()};
}

double median_zdepth(const ColmapModel& model) {
  std::map<uint32_t, Rigid> pose;
  for (const ColmapImage& image : model.images) pose[image.id] = image.cam_from_world();
  std::vector<double> depths;
  for (const ColmapPoint3D& p : model.points)
    for (const ColmapTrackElement& t : p.track) depths.push_back((pose.at(t.image_id) * p.position).z);
  if (depths.empty()) return 0;
  return upper_median(std::move(depths));
}

// All cameras have the same viewing direction, and either the image up vectors differ, or the cameras cover an area (not a line)
// as wide as the distance of the scene: a flight over ground, not a walk along a wall.
bool looks_straight_down(const ColmapModel& model, const Cameras& c) {
  if (length(c.mean_forward) < kParallel) return false;
  if (length(c.mean_up) < 0.7) return true;
  const Spread s = spread_of(c.centres, c.centroid);
  const bool area = s.values(1) > 0.2 * s.values(2) && s.values(0) < 0.3 * s.values(1);
  const bool seen_from_its_normal = std::abs(s.directions.col(0).dot(eigen(normalized(c.mean_forward)))) > kParallel;
  return area && seen_from_its_normal && s.values(1) > 0.35 * median_zdepth(model);
}

std::optional<Vec3d> up_from_right_vectors(const Cameras& c) {
  std::vector<double> weight(c.right.size(), 1.0);
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  constexpr int kRounds = 10;
  constexpr double kLevelSigma = 0.05;  // about 3 degrees: typical roll of hand-held cameras
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
    double total = 0;
    for (size_t i = 0; i < c.right.size(); ++i) {
      m += weight[i] * eigen(c.right[i]) * eigen(c.right[i]).transpose();
      total += weight[i];
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(m / total);
    // The second eigenvalue must be large enough: headings have to differ by at least about 15 degrees.
    if (solver.eigenvalues()(1) < 0.02) return std::nullopt;
    up = solver.eigenvectors().col(0);
    for (size_t i = 0; i < c.right.size(); ++i) {
      const double roll = eigen(c.right[i]).dot(up) / kLevelSigma;
      weight[i] = 1 / (1 + roll * roll);
    }
  }
  return up.dot(eigen(c.mean_up)) < 0 ? ours(-up) : ours(up);
}

}  // namespace

Orientation scene_up(const ColmapModel& model, UpMethod method) {
  const Cameras c = cameras_of(model);
  const auto unit_or_z = [](const Vec3d& v) { return length(v) > 1e-6 ? normalized(v) : Vec3d{0, 0, 1}; };
  if (method == UpMethod::Nadir || (method == UpMethod::Auto && looks_straight_down(model, c)))
    return {unit_or_z(-c.mean_forward), UpMethod::Nadir};
  if (method == UpMethod::Mean) return {unit_or_z(c.mean_up), UpMethod::Mean};
  const std::optional<Vec3d> level = up_from_right_vectors(c);
  const Orientation coarse = level ? Orientation{*level, UpMethod::Level} : Orientation{unit_or_z(c.mean_up), UpMethod::Mean};
  if (method == UpMethod::Level) return coarse;
  const Spread s = spread_of(c.centres, c.centroid);
  Vec3d normal = ours(s.directions.col(0));
  if (dot(normal, coarse.up) < 0) normal = -normal;
  const bool ring = c.centres.size() >= 6 && s.values(0) < kFlatRing * s.values(1) && s.values(1) > 0.3 * s.values(2) &&
                    dot(normal, coarse.up) > kRingTilt;
  if (method == UpMethod::Ring || (method == UpMethod::Auto && ring)) return {normal, UpMethod::Ring};
  return coarse;
}

Similarity scene_from_colmap(const ColmapModel& model, const Orientation& orientation, const Vec3d& east) {
  const Cameras c = cameras_of(model);
  VITRINE_CHECK(!c.centres.empty(), "no camera to orient a scene by");
  const Vec3d z = normalized(orientation.up);
  // Heading: direction from the centroid to the first camera, so that the frame depends only on the model.
  Vec3d x{};
  for (const Vec3d& seed : {east, c.centres[0] - c.centroid, c.right[0], Vec3d{1, 0, 0}, Vec3d{0, 1, 0}}) {
    x = seed - dot(seed, z) * z;
    if (length(x) > 1e-6 * (1e-300 + length(seed))) break;
  }
  x = normalized(x);
  const Vec3d y = cross(z, x);
  Similarity s;
  s.rotation = transposed(Mat3d{x, y, z});
  std::vector<double> distances;
  for (const Vec3d& centre : c.centres) distances.push_back(length(centre - c.centroid));
  const size_t at = std::min(distances.size() - 1, static_cast<size_t>(std::ceil(0.95 * double(distances.size()))) - 1);
  const double ring = order_statistic_of(std::span(distances), at), radius = ring > 0 ? ring : std::ranges::max(distances);
  s.scale = radius > 0 ? 1 / radius : 1;
  s.translation = -s.scale * (s.rotation * c.centroid);
  return s;
}

}  // namespace vitrine
