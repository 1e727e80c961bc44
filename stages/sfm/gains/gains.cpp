#include "stages/sfm/gains/gains.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/math/median.h"

namespace vitrine {

namespace {

// log(observed) - log(gain) - log(colour), all scalars: the channels are solved one by one.
class ColourResidual final : public ceres::SizedCostFunction<1, 1, 1> {
 public:
  explicit ColourResidual(double log_observed) : log_observed_(log_observed) {}
  bool Evaluate(double const* const* x, double* residual, double** jacobians) const override {
    residual[0] = log_observed_ - x[0][0] - x[1][0];
    if (jacobians) {
      for (int i = 0; i < 2; ++i)
        if (jacobians[i]) jacobians[i][0] = -1;
    }
    return true;
  }

 private:
  double log_observed_;
};

class Prior final : public ceres::SizedCostFunction<1, 1> {
 public:
  explicit Prior(double sigma) : weight_(1 / sigma) {}
  bool Evaluate(double const* const* x, double* residual, double** jacobians) const override {
    residual[0] = weight_ * x[0][0];
    if (jacobians && jacobians[0]) jacobians[0][0] = weight_;
    return true;
  }

 private:
  double weight_;
};

struct Observation {
  uint32_t view, point;
  double log_value;
};

// One channel's observations: in range, of points seen by two views or more, of the longest tracks.
std::vector<Observation> observations_of(std::span<const GainSample> samples, size_t channel, size_t point_count,
                                         const GainSettings& settings) {
  std::vector<Observation> all;
  std::vector<uint32_t> seen(point_count, 0);
  for (const GainSample& s : samples) {
    const float value = s.linear_rgb[channel];
    if (!(value >= settings.darkest && value <= settings.brightest)) continue;
    all.push_back({s.view, s.point, std::log(static_cast<double>(value))});
    ++seen[s.point];
  }
  std::vector<uint32_t> points;
  for (uint32_t k = 0; k < point_count; ++k)
    if (seen[k] >= 2) points.push_back(k);
  std::stable_sort(points.begin(), points.end(), [&](uint32_t a, uint32_t b) { return seen[a] > seen[b]; });
  if (points.size() > settings.max_points) points.resize(settings.max_points);
  std::vector<bool> keep(point_count, false);
  for (uint32_t k : points) keep[k] = true;
  std::erase_if(all, [&](const Observation& o) { return !keep[o.point]; });
  return all;
}

class ChannelProblem {
 public:
  ChannelProblem(size_t views, size_t points, std::vector<Observation> observations, const GainSettings& settings)
      : observations_(std::move(observations)),
        log_gain_(views, 0.0),
        log_colour_(points, 0.0),
        count_(views, 0),
        settings_(settings) {
    std::vector<double> weight(points, 0.0);
    for (const Observation& o : observations_) {
      ++count_[o.view];
      log_colour_[o.point] += o.log_value;
      weight[o.point] += 1;
    }
    for (size_t k = 0; k < points; ++k)
      if (weight[k] > 0) log_colour_[k] /= weight[k];
  }

  // First a convex loss, which finds the one minimum from anywhere (exposures may differ by stops); then, from there, one that
  // forgets outliers.
  void solve() {
    if (observations_.empty()) return;
    minimise(new ceres::HuberLoss(kStartScale), kStartScale);
    const double scale = std::clamp(spread(), kMinScale, kMaxScale);
    minimise(new ceres::CauchyLoss(scale), scale);
  }

  // The standard deviation of a normal core, from the median absolute residual.
  double spread() const {
    std::vector<double> residuals;
    residuals.reserve(observations_.size());
    for (const Observation& o : observations_)
      residuals.push_back(std::abs(o.log_value - log_gain_[o.view] - log_colour_[o.point]));
    return residuals.empty() ? 0 : kSigmaPerDeviation * upper_median(std::move(residuals));
  }

  bool determined(size_t view) const { return count_[view] >= settings_.min_samples; }
  double log_gain(size_t view) const { return log_gain_[view]; }
  size_t size() const { return observations_.size(); }

 private:
  static constexpr double kStartScale = 0.05, kMinScale = 0.005, kMaxScale = 0.3;

  // `sigma` of a sample sets what the prior weighs against it.
  void minimise(ceres::LossFunction* loss, double sigma) {
    ceres::Problem problem;                              // owns loss and costs
    auto* ordering = new ceres::ParameterBlockOrdering;  // colours are eliminated first: each depends on gains alone
    for (const Observation& o : observations_)
      problem.AddResidualBlock(new ColourResidual(o.log_value), loss, &log_gain_[o.view], &log_colour_[o.point]);
    for (size_t v = 0; v < log_gain_.size(); ++v) {
      if (count_[v] == 0) continue;
      problem.AddResidualBlock(new Prior(settings_.prior_sigma / sigma), nullptr, &log_gain_[v]);
      ordering->AddElementToGroup(&log_gain_[v], 1);
    }
    for (double& colour : log_colour_)
      if (problem.HasParameterBlock(&colour)) ordering->AddElementToGroup(&colour, 0);
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::DENSE_SCHUR;
    options.linear_solver_ordering.reset(ordering);
    options.num_threads = 1;  // more would sum in an order of their own
    options.logging_type = ceres::SILENT;
    // Colours of points seen twice, once wrongly, creep on for ever under the second loss; the gains stand long before.
    options.max_num_iterations = 15;
    options.function_tolerance = 1e-4;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    VITRINE_CHECK(summary.IsSolutionUsable(), "gains: {}", summary.message);
  }

  std::vector<Observation> observations_;
  std::vector<double> log_gain_, log_colour_;
  std::vector<size_t> count_;
  const GainSettings& settings_;
};

bool looks_fixed(const std::vector<Vec3d>& gains, const GainSettings& settings) {
  for (size_t c = 0; c < 3; ++c) {
    double squares = 0;
    for (const Vec3d& gain : gains) {
      const double log_gain = std::log(gain[c]);
      if (std::abs(log_gain) > settings.fixed_largest) return false;
      squares += log_gain * log_gain;
    }
    if (squares > settings.fixed_deviation * settings.fixed_deviation * static_cast<double>(gains.size())) return false;
  }
  return true;
}

}  // namespace

GainSolution solve_gains(size_t view_count, size_t point_count, std::span<const GainSample> samples,
                         const GainSettings& settings) {
  for (const GainSample& s : samples)
    VITRINE_CHECK(s.view < view_count && s.point < point_count, "sample of view {} and point {}", s.view, s.point);
  GainSolution solution;
  solution.gains.assign(view_count, {1, 1, 1});
  std::vector<bool> undetermined(view_count, false);
  for (size_t c = 0; c < 3; ++c) {
    ChannelProblem channel(view_count, point_count, observations_of(samples, c, point_count, settings), settings);
    channel.solve();
    double sum = 0, count = 0;
    for (size_t v = 0; v < view_count; ++v) {
      if (!channel.determined(v)) continue;
      sum += channel.log_gain(v);
      count += 1;
    }
    for (size_t v = 0; v < view_count; ++v) {
      if (channel.determined(v))
        solution.gains[v][c] = std::exp(channel.log_gain(v) - sum / count);
      else
        undetermined[v] = true;
    }
    solution.samples += channel.size();
    solution.spread = std::max(solution.spread, channel.spread());
  }
  for (uint32_t v = 0; v < view_count; ++v)
    if (undetermined[v]) solution.undetermined.push_back(v);
  solution.fixed_exposure = looks_fixed(solution.gains, settings);
  if (solution.fixed_exposure) solution.gains.assign(view_count, {1, 1, 1});
  return solution;
}

}  // namespace vitrine
