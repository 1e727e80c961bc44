#include "stages/evaluate/alignment.h"

#include <algorithm>
#include <limits>
#include <numbers>

#include <Eigen/Dense>

#include "core/foundation/base/error.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {
namespace {

constexpr double kOutlierFactor = 8;  // in medians: centres farther from their partner are outliers
constexpr double kNoiseFloor = 1e-9;  // of the ring radius: exact poses have no outliers
constexpr double kLineRatio = 1e-5;   // second / first singular value: below it, centres are collinear
constexpr int kTrimmingRounds = 5;
constexpr size_t kPartners = 64;  // neighbours in name order used for a camera's distances

Eigen::Vector3d eigen(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3d vec(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Eigen::Matrix3d eigen(const Mat3d& m) {
  Eigen::Matrix3d e;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) e(r, c) = m(size_t(r), size_t(c));
  return e;
}
Mat3d mat(const Eigen::Matrix3d& e) { return {vec(e.col(0)), vec(e.col(1)), vec(e.col(2))}; }

// Nearest proper rotation to `m`; `singular_values` in descending order.
Eigen::Matrix3d nearest_rotation(const Eigen::Matrix3d& m, Eigen::Vector3d* singular_values, double* sign) {
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(m, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double s = svd.matrixU().determinant() * svd.matrixV().determinant() < 0 ? -1 : 1;
  if (singular_values) *singular_values = svd.singularValues();
  if (sign) *sign = s;
  return svd.matrixU() * Eigen::Vector3d(1, 1, s).asDiagonal() * svd.matrixV().transpose();
}

struct Fit {
  Similarity similarity;
  bool on_a_line = false;
};

Fit fit(std::span<const Vec3d> from, std::span<const Vec3d> to) {
  VITRINE_CHECK(from.size() == to.size() && from.size() >= 2, "{} and {} points", from.size(), to.size());
  Eigen::Vector3d mean_from = Eigen::Vector3d::Zero(), mean_to = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < from.size(); ++i) mean_from += eigen(from[i]), mean_to += eigen(to[i]);
  mean_from /= double(from.size());
  mean_to /= double(to.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  double variance = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d a = eigen(from[i]) - mean_from, b = eigen(to[i]) - mean_to;
    covariance += b * a.transpose();
    variance += a.squaredNorm();
  }
  VITRINE_CHECK(variance > 0, "all points coincide");
  Eigen::Vector3d sigma;
  double sign = 1;
  const Eigen::Matrix3d rotation = nearest_rotation(covariance, &sigma, &sign);
  const double scale = (sigma.x() + sigma.y() + sign * sigma.z()) / variance;
  Fit result;
  result.similarity = {scale, mat(rotation), vec(mean_to - scale * rotation * mean_from)};
  result.on_a_line = sigma.y() <= kLineRatio * sigma.x();
  return result;
}

// Rotation from the camera orientations: R = nearest rotation to sum_i R_truth_i^T R_ours_i. Scale and translation from the
// centres.
Similarity fit_by_orientations(std::span<const CameraPair> cameras, std::span<const Vec3d> from, std::span<const Vec3d> to) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const CameraPair& c : cameras) sum += eigen(c.truth.rotation).transpose() * eigen(c.ours.rotation);
  const Eigen::Matrix3d rotation = nearest_rotation(sum, nullptr, nullptr);
  Eigen::Vector3d mean_from = Eigen::Vector3d::Zero(), mean_to = Eigen::Vector3d::Zero();
  for (size_t i = 0; i < from.size(); ++i) mean_from += eigen(from[i]), mean_to += eigen(to[i]);
  mean_from /= double(from.size());
  mean_to /= double(to.size());
  double numerator = 0, denominator = 0;
  for (size_t i = 0; i < from.size(); ++i) {
    const Eigen::Vector3d a = rotation * (eigen(from[i]) - mean_from);
    numerator += a.dot(eigen(to[i]) - mean_to);
    denominator += a.squaredNorm();
  }
  const double scale = numerator / denominator;
  return {scale, mat(rotation), vec(mean_to - scale * rotation * mean_from)};
}

Vec3d centre(const Rigid& cam_from_world) { return inverse(cam_from_world).translation; }

double extent(const std::vector<Vec3d>& points) {
  double largest = 0;
  for (const Vec3d& p : points) largest = std::max(largest, length(p - points[0]));
  return largest;
}

std::vector<double> centre_residuals(std::span<const CameraPair> cameras, const Similarity& truth_from_ours) {
  std::vector<double> residuals;
  for (const CameraPair& c : cameras) residuals.push_back(length(truth_from_ours * centre(c.ours) - centre(c.truth)));
  return residuals;
}

// Least median: scale = median ratio of distances between centres; every camera proposes its own relative rotation, with the
// median translation per coordinate; the proposal with the smallest median residual wins. Tolerates up to half wrong cameras.
Similarity robust_start(std::span<const CameraPair> cameras) {
  std::vector<double> ratios;
  for (size_t i = 0; i < cameras.size(); ++i)
    for (size_t step = 1; step <= kPartners && i + step < cameras.size(); ++step) {
      const size_t j = i + step;
      const double ours = length(centre(cameras[i].ours) - centre(cameras[j].ours));
      if (ours > 0) ratios.push_back(length(centre(cameras[i].truth) - centre(cameras[j].truth)) / ours);
    }
  const double scale = median(ratios);
  Similarity best;
  double best_residual = std::numeric_limits<double>::infinity();
  for (const CameraPair& proposer : cameras) {
    Similarity s{scale, transposed(proposer.truth.rotation) * proposer.ours.rotation, {}};
    for (size_t axis = 0; axis < 3; ++axis) {
      std::vector<double> shifts;
      for (const CameraPair& c : cameras) shifts.push_back((centre(c.truth) - s * centre(c.ours))[axis]);
      // Only this coordinate: the others are still 0 and have no effect.
      s.translation[axis] = median(shifts);
    }
    const double residual = median(centre_residuals(cameras, s));
    if (residual < best_residual) best = s, best_residual = residual;
  }
  return best;
}

}  // namespace

double rotation_angle_deg(const Mat3d& a, const Mat3d& b) {
  const Eigen::Matrix3d d = eigen(a) * eigen(b).transpose();
  const double sine = 0.5 * Eigen::Vector3d(d(2, 1) - d(1, 2), d(0, 2) - d(2, 0), d(1, 0) - d(0, 1)).norm();
  return std::atan2(sine, 0.5 * (d.trace() - 1)) * 180 / std::numbers::pi;
}

Similarity umeyama(std::span<const Vec3d> from, std::span<const Vec3d> to) { return fit(from, to).similarity; }

double ring_radius(std::span<const CameraPair> cameras) {
  Vec3d mean{};
  for (const CameraPair& c : cameras) mean += centre(c.truth);
  mean = mean / double(cameras.size());
  std::vector<double> distances;
  for (const CameraPair& c : cameras) distances.push_back(length(centre(c.truth) - mean));
  return order_statistic_of(std::span(distances), std::min(distances.size() - 1, size_t(0.95 * double(distances.size()))));
}

Alignment align_cameras(std::span<const CameraPair> cameras, const std::string& where) {
  const double radius = cameras.empty() ? 0 : ring_radius(cameras);
  std::vector<Vec3d> our_centres;
  for (const CameraPair& c : cameras) our_centres.push_back(centre(c.ours));
  if (cameras.size() < 2 || !(radius > 0) || !(extent(our_centres) > 0))
    throw Error(ErrorKind::Input, "the truth cannot be aligned with the reconstruction",
                {.where = where,
                 .why = fmt::format("{} cameras in common; at least two with different centres are needed", cameras.size()),
                 .hint = "check that file_path in transforms.json names the photos of this run",
                 .code = "TRUTH_NOT_ALIGNED"});
  Alignment result;
  result.truth_from_ours = robust_start(cameras);
  std::vector<CameraPair> kept;
  for (int round = 0; round < kTrimmingRounds; ++round) {
    const std::vector<double> residuals = centre_residuals(cameras, result.truth_from_ours);
    const double limit = std::max(kOutlierFactor * median(residuals), kNoiseFloor * radius);
    std::vector<CameraPair> inside;
    std::vector<Vec3d> from, to;
    for (size_t i = 0; i < cameras.size(); ++i)
      if (residuals[i] <= limit) {
        inside.push_back(cameras[i]);
        from.push_back(centre(cameras[i].ours));
        to.push_back(centre(cameras[i].truth));
      }
    if (inside.size() == kept.size() || !(extent(from) > 0) || !(extent(to) > 0)) break;
    kept = std::move(inside);
    const Fit f = fit(from, to);
    result.used = kept.size();
    result.by_orientations = f.on_a_line;
    result.truth_from_ours = f.on_a_line ? fit_by_orientations(kept, from, to) : f.similarity;
  }
  if (!(result.truth_from_ours.scale > 0))
    throw Error(ErrorKind::Input, "the truth's cameras do not resemble the reconstruction's",
                {.where = where,
                 .why = "the best similarity has no positive scale",
                 .hint = "check that transforms.json belongs to these photos",
                 .code = "TRUTH_NOT_ALIGNED"});
  return result;
}

std::vector<PoseError> pose_errors(std::span<const CameraPair> cameras, const Similarity& truth_from_ours) {
  const double radius = ring_radius(cameras);
  std::vector<PoseError> errors;
  for (const CameraPair& c : cameras) {
    const Rigid ours = transformed_world(c.ours, truth_from_ours);
    errors.push_back({rotation_angle_deg(ours.rotation, c.truth.rotation), length(centre(ours) - centre(c.truth)) / radius});
  }
  return errors;
}

}  // namespace vitrine
