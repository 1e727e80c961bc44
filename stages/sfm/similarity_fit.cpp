#include "stages/sfm/similarity_fit.h"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {

constexpr double kSigmas = 3;  // of the distances at which pairs agree

Eigen::Vector3d to_eigen(const Vec3d& v) { return {v.x, v.y, v.z}; }
Vec3d from_eigen(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

double cost_of(const Similarity& s, const SpotPair& pair) {
  const Vec3d d = s * pair.from - pair.to;
  const double v = pair.height_known ? d.z / kVerticalRatio : 0;
  return (d.x * d.x + d.y * d.y + v * v) / (pair.reach * pair.reach);
}

double prior_cost(const Similarity& s, const UpPrior& up) {
  return squared_length(s.rotation * up.direction - Vec3d{0, 0, 1}) / (up.sigma * up.sigma);
}

Eigen::Matrix3d cross_matrix(const Vec3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z, v.y, v.z, 0, -v.x, -v.y, v.x, 0;
  return m;
}

// Normal equations of the seven parameters: rotation vector (on the left), logarithm of the scale, translation.
class NormalEquations {
 public:
  using Row = Eigen::Matrix<double, 1, 7>;
  void add(const Row& row, double residual, double sigma) {
    matrix_ += row.transpose() * row / (sigma * sigma);
    right_ -= row.transpose() * residual / (sigma * sigma);
  }
  Eigen::Matrix<double, 7, 1> solution() const {
    // A weak prior on no change keeps undetermined directions in place.
    const Eigen::Matrix<double, 7, 7> damped = matrix_ + 1e-9 * matrix_.trace() * Eigen::Matrix<double, 7, 7>::Identity();
    return damped.ldlt().solve(right_);
  }

 private:
  Eigen::Matrix<double, 7, 7> matrix_ = Eigen::Matrix<double, 7, 7>::Zero();
  Eigen::Matrix<double, 7, 1> right_ = Eigen::Matrix<double, 7, 1>::Zero();
};

// One step, with the parameters around `middle` of the model.
Similarity stepped(const Similarity& s, std::span<const SpotPair> pairs, const UpPrior& up, const Vec3d& middle) {
  NormalEquations equations;
  const Vec3d at = s * middle;
  for (const SpotPair& pair : pairs) {
    if (!agrees(s, pair)) continue;
    const Vec3d arm = s * pair.from - at, d = s * pair.from - pair.to;
    Eigen::Matrix<double, 3, 7> rows;
    rows << -cross_matrix(arm), to_eigen(arm), Eigen::Matrix3d::Identity();
    for (int i = 0; i < (pair.height_known ? 3 : 2); ++i)
      equations.add(rows.row(i), d[size_t(i)], pair.reach * (i < 2 ? 1 : kVerticalRatio) / kSigmas);
  }
  const Vec3d turned = s.rotation * up.direction;
  const Eigen::Matrix3d turning = -cross_matrix(turned);
  for (int i = 0; i < 3; ++i) {
    NormalEquations::Row row = NormalEquations::Row::Zero();
    row.head<3>() = turning.row(i);
    equations.add(row, turned[size_t(i)] - (i == 2 ? 1 : 0), up.sigma);
  }
  const Eigen::Matrix<double, 7, 1> x = equations.solution();
  const Eigen::Vector3d w = x.head<3>();
  const double angle = w.norm();
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
  if (angle > 0) turn = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  const Mat3d rotation{from_eigen(turn * to_eigen(s.rotation.c0)), from_eigen(turn * to_eigen(s.rotation.c1)),
                       from_eigen(turn * to_eigen(s.rotation.c2))};
  Similarity out{s.scale * std::exp(std::clamp(x(3), -1.0, 1.0)), rotation_matrix(quaternion(rotation)), {}};
  out.translation = at + from_eigen(x.tail<3>()) - out.scale * (out.rotation * middle);
  return out;
}

}  // namespace

bool agrees(const Similarity& s, const SpotPair& pair) { return cost_of(s, pair) < 1; }

double truncated_cost(const Similarity& s, std::span<const SpotPair> pairs, const UpPrior& up) {
  double cost = prior_cost(s, up) / (kSigmas * kSigmas);
  for (const SpotPair& pair : pairs) cost += std::min(1.0, cost_of(s, pair));
  return cost;
}

std::optional<Similarity> similarity_of_two(const SpotPair& a, const SpotPair& b, const Vec3d& up) {
  const Vec3d arm = b.from - a.from, level = arm - dot(arm, up) * up;
  const double length_from = length(level), length_to = std::hypot(b.to.x - a.to.x, b.to.y - a.to.y);
  if (!(length_from > 1e-6 * length(arm)) || !(length_to > 0)) return std::nullopt;
  // Axes of the model in the order of the segment, of its left side and of up, taken to the same of the local frame.
  const Vec3d x = level / length_from, y = cross(up, x);
  const Vec3d u = Vec3d{b.to.x - a.to.x, b.to.y - a.to.y, 0} / length_to, v = cross(Vec3d{0, 0, 1}, u);
  const Mat3d rows = transposed(Mat3d{x, y, up});
  const Mat3d local{u, v, Vec3d{0, 0, 1}};
  Similarity s{length_to / length_from, Mat3d{local * rows.c0, local * rows.c1, local * rows.c2}, {}};
  s.translation = 0.5 * (a.to + b.to) - s.scale * (s.rotation * (0.5 * (a.from + b.from)));
  return s;
}

std::optional<Similarity> similarity_of_three(const SpotPair& a, const SpotPair& b, const SpotPair& c) {
  const auto narrow = [](const Vec3d& p, const Vec3d& q, const Vec3d& r) {
    const double longest = std::max({length(q - p), length(r - p), length(r - q)});
    return !(length(cross(q - p, r - p)) > 1e-3 * longest * longest);
  };
  if (narrow(a.from, b.from, c.from) || narrow(a.to, b.to, c.to)) return std::nullopt;
  Eigen::Matrix3d from, to;
  from << to_eigen(a.from), to_eigen(b.from), to_eigen(c.from);
  to << to_eigen(a.to), to_eigen(b.to), to_eigen(c.to);
  const Eigen::Matrix4d m = Eigen::umeyama(from, to, true);
  const double scale = std::cbrt(m.topLeftCorner<3, 3>().determinant());
  if (!std::isfinite(scale) || !(scale > 0)) return std::nullopt;
  const Eigen::Matrix3d r = m.topLeftCorner<3, 3>() / scale;
  return Similarity{
      scale, {from_eigen(r.col(0)), from_eigen(r.col(1)), from_eigen(r.col(2))}, from_eigen(m.topRightCorner<3, 1>())};
}

Similarity refined(const Similarity& start, std::span<const SpotPair> pairs, const UpPrior& up) {
  Vec3d middle{};
  for (const SpotPair& pair : pairs) middle += pair.from / double(pairs.size());
  constexpr int kSteps = 8;
  Similarity s = start;
  for (int i = 0; i < kSteps; ++i) s = stepped(s, pairs, up, middle);
  return s;
}

}  // namespace vitrine
