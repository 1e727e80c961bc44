#include "stages/sfm/gains/gains.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/median.h"
#include "stages/sfm/gains/ceres_log.h"

namespace vitrine {

namespace {

// Five pixels: features are blobs of at least this size, and a pose error of half a pixel hardly shifts the window.
constexpr int kRadius = 2;
// Of full scale, in linear light: code 249 of 255. Resampling slightly lowers a clipped pixel.
constexpr float kClipped = 0.95f;

// (log(observed) - log(gain of the channel) - log(colour)) / sigma
class ColourResidual final : public ceres::SizedCostFunction<1, 3, 1> {
 public:
  ColourResidual(size_t channel, double log_observed, double sigma)
      : channel_(channel), log_observed_(log_observed), weight_(1 / sigma) {}
  bool Evaluate(double const* const* x, double* residual, double** jacobians) const override {
    residual[0] = weight_ * (log_observed_ - x[0][channel_] - x[1][0]);
    if (!jacobians) return true;
    if (jacobians[0])
      for (size_t c = 0; c < 3; ++c) jacobians[0][c] = c == channel_ ? -weight_ : 0;
    if (jacobians[1]) jacobians[1][0] = -weight_;
    return true;
  }

 private:
  size_t channel_;
  double log_observed_, weight_;
};

// (mean over channels of log(gain) - expected) / sigma
class ExposurePrior final : public ceres::SizedCostFunction<1, 3> {
 public:
  ExposurePrior(double expected, double sigma) : expected_(expected), weight_(1 / sigma) {}
  bool Evaluate(double const* const* x, double* residual, double** jacobians) const override {
    residual[0] = weight_ * ((x[0][0] + x[0][1] + x[0][2]) / 3 - expected_);
    if (jacobians && jacobians[0])
      for (size_t i = 0; i < 3; ++i) jacobians[0][i] = weight_ / 3;
    return true;
  }

 private:
  double expected_, weight_;
};

// (log(gain_c) - mean over channels) / sigma
class BalancePrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  explicit BalancePrior(double sigma) : weight_(1 / sigma) {}
  bool Evaluate(double const* const* x, double* residuals, double** jacobians) const override {
    const double mean = (x[0][0] + x[0][1] + x[0][2]) / 3;
    for (size_t c = 0; c < 3; ++c) residuals[c] = weight_ * (x[0][c] - mean);
    if (jacobians && jacobians[0])
      for (size_t c = 0; c < 3; ++c)
        for (size_t i = 0; i < 3; ++i) jacobians[0][3 * c + i] = weight_ * ((c == i ? 1.0 : 0.0) - 1.0 / 3);
    return true;
  }

 private:
  double weight_;
};

struct Observation {
  uint32_t view, point;
  double log_value, expected;
};

// Standard deviation of log(observed): a relative part and an additive part (rounding, chroma subsampling, interreflection),
// which dominates in dark samples.
struct Noise {
  double spread, floor;
  double sigma(double value) const { return std::hypot(spread, floor / value); }
};

// Observations of one channel: in range, of views with enough samples, of points with at least two such views, of the longest
// tracks.
struct Channel {
  std::vector<Observation> observations;
  std::vector<size_t> of_view;   // [views] number of observations
  std::vector<bool> determined;  // [views]
  std::vector<double> weight;    // [points] weight of each observation of the point, as samples of a photo are correlated
};

Channel channel_of(std::span<const GainSample> samples, size_t c, size_t views, size_t points, const GainSettings& settings) {
  Channel channel;
  std::vector<uint32_t> seen(points, 0);
  for (const GainSample& s : samples) {
    const double value = static_cast<double>(s.linear_rgb[c]);
    if (!(s.linear_rgb[c] >= settings.darkest && s.linear_rgb[c] <= settings.brightest)) continue;
    channel.observations.push_back({s.view, s.point, std::log(value), value});
    ++seen[s.point];
  }
  std::vector<uint32_t> longest;
  for (uint32_t k = 0; k < points; ++k)
    if (seen[k] >= 2) longest.push_back(k);
  std::stable_sort(longest.begin(), longest.end(), [&](uint32_t a, uint32_t b) { return seen[a] > seen[b]; });
  if (longest.size() > settings.max_points) longest.resize(settings.max_points);
  std::vector<bool> keep(points, false);
  for (uint32_t k : longest) keep[k] = true;
  std::erase_if(channel.observations, [&](const Observation& o) { return !keep[o.point]; });
  const auto count = [&] {
    channel.of_view.assign(views, 0);
    for (const Observation& o : channel.observations) ++channel.of_view[o.view];
  };
  count();
  channel.determined.resize(views);
  for (size_t v = 0; v < views; ++v) channel.determined[v] = channel.of_view[v] >= settings.min_samples;
  std::erase_if(channel.observations, [&](const Observation& o) { return !channel.determined[o.view]; });
  count();
  channel.weight.assign(points, 0);
  for (const Observation& o : channel.observations) {
    const double n = double(channel.of_view[o.view]);
    channel.weight[o.point] =
        std::max(channel.weight[o.point], settings.independent_samples / (settings.independent_samples + n));
  }
  return channel;
}

class Problem {
 public:
  Problem(std::vector<Channel> channels, size_t points, std::vector<double> exposures, const GainSettings& settings)
      : channels_(std::move(channels)), exposures_(std::move(exposures)), log_colour_(points, Vec3d()), settings_(settings) {
    for (double e : exposures_) of_view_.push_back({e, e, e});
    for (size_t c = 0; c < 3; ++c) {
      std::vector<double> count(points, 0);
      for (const Observation& o : channels_[c].observations) {
        log_colour_[o.point][c] += o.log_value - exposures_[o.view];
        count[o.point] += 1;
      }
      for (size_t k = 0; k < points; ++k)
        if (count[k] > 0) log_colour_[k][c] /= count[k];
    }
  }

  // 1. Convex loss, all samples at full weight: a unique minimum from any start (exposures may differ by stops). Its residuals
  // give the noise. 2. Same with the known noise, and samples capped against the prior; still convex. 3. From there, a robust
  // non-convex loss that rejects outliers.
  void solve() {
    Terms terms{.noise = kStart, .exposure_sigma = settings_.exposure_sigma, .balance_sigma = settings_.balance_sigma};
    minimise<ceres::HuberLoss>(terms);
    for (size_t c = 0; c < 3; ++c)
      for (Observation& o : channels_[c].observations) o.expected = std::exp(of_view_[o.view][c] + log_colour_[o.point][c]);
    terms.noise = noise();
    terms.capped = true;
    minimise<ceres::HuberLoss>(terms);
    widen(terms);
    minimise<ceres::CauchyLoss>(terms);
  }

  // Robust standard deviation (inlier core) from the median absolute residual.
  double spread(size_t c) const { return spread_of(residuals_of(c)); }

  const std::vector<Channel>& channels() const { return channels_; }
  double log_gain(size_t view, size_t c) const { return of_view_[view][c]; }

 private:
  static constexpr Noise kStart{0.05, 0.01}, kLeast{0.005, 0.001}, kMost{0.3, 0.05};
  static constexpr double kWider = 2;  // the narrow prior of step 2 removes up to half of a balance

  struct Residual {
    double value, size;
  };
  std::vector<Residual> residuals_of(size_t c) const {
    std::vector<Residual> residuals;
    residuals.reserve(channels_[c].observations.size());
    for (const Observation& o : channels_[c].observations)
      residuals.push_back({o.expected, std::abs(o.log_value - of_view_[o.view][c] - log_colour_[o.point][c])});
    return residuals;
  }

  static double spread_of(std::span<const Residual> residuals) {
    std::vector<double> sizes;
    for (const Residual& r : residuals) sizes.push_back(r.size);
    return sizes.empty() ? 0 : kSigmaPerDeviation * upper_median(std::move(sizes));
  }

  // Separates the noise parts by the spreads of the darker and the brighter half of the residuals: spread^2 = relative^2 + (floor
  // / value)^2 in both halves.
  Noise noise() const {
    std::vector<Residual> all;
    for (size_t c = 0; c < 3; ++c) {
      const std::vector<Residual> some = residuals_of(c);
      all.insert(all.end(), some.begin(), some.end());
    }
    if (all.size() < 4) return kStart;
    std::stable_sort(all.begin(), all.end(), [](const Residual& a, const Residual& b) { return a.value < b.value; });
    const std::span<const Residual> dark = std::span(all).first(all.size() / 2), bright = std::span(all).subspan(all.size() / 2);
    const auto square = [](double x) { return x * x; };
    const double a = 1 / square(dark[dark.size() / 2].value), b = 1 / square(bright[bright.size() / 2].value);
    const double floor = std::sqrt(std::max(0.0, square(spread_of(dark)) - square(spread_of(bright))) / (a - b));
    const Noise n{0, std::clamp(a > b ? floor : 0.0, kLeast.floor, kMost.floor)};
    const double spread = std::sqrt(std::max(0.0, square(spread_of(bright)) - square(n.floor) * b));
    return {std::clamp(spread, kLeast.spread, kMost.spread), n.floor};
  }

  struct Terms {
    Noise noise;
    double exposure_sigma, balance_sigma;
    bool capped = false;
  };

  // Photos whose exposures or balances differ by more than the prior expects were taken with automatic exposure or white balance:
  // widen the prior to their spread.
  void widen(Terms& terms) const {
    double exposure = 0, exposures = 0, balances = 0;
    for (size_t v = 0; v < of_view_.size(); ++v) {
      const auto& x = of_view_[v];
      const double mean = (x[0] + x[1] + x[2]) / 3, e = mean - exposures_[v];
      exposure += e, exposures += e * e;
      for (size_t c = 0; c < 3; ++c) balances += (x[c] - mean) * (x[c] - mean);
    }
    const double n = double(std::max<size_t>(of_view_.size(), 1));
    terms.exposure_sigma =
        std::max(terms.exposure_sigma, std::sqrt(std::max(0.0, exposures / n - exposure * exposure / (n * n))));
    terms.balance_sigma = std::max(terms.balance_sigma, kWider * std::sqrt(balances / (2 * n)));  // of two dimensions
  }

  template <class Loss>
  void minimise(const Terms& terms) {
    ceres::Problem problem;                              // owns losses and costs
    auto* ordering = new ceres::ParameterBlockOrdering;  // eliminates colours first (Schur complement)
    for (size_t c = 0; c < 3; ++c) {
      Channel& channel = channels_[c];
      std::vector<ceres::LossFunction*> loss(channel.weight.size(), nullptr);
      for (const Observation& o : channel.observations) {
        if (!loss[o.point]) {
          loss[o.point] = new ceres::ScaledLoss(new Loss(1), terms.capped ? channel.weight[o.point] : 1, ceres::TAKE_OWNERSHIP);
          ordering->AddElementToGroup(&log_colour_[o.point][c], 0);
        }
        problem.AddResidualBlock(new ColourResidual(c, o.log_value, terms.noise.sigma(o.expected)), loss[o.point],
                                 of_view_[o.view].data(), &log_colour_[o.point][c]);
      }
    }
    auto* prior_loss = new ceres::HuberLoss(1);
    for (size_t v = 0; v < of_view_.size(); ++v) {
      problem.AddResidualBlock(new ExposurePrior(exposures_[v], terms.exposure_sigma), prior_loss, of_view_[v].data());
      problem.AddResidualBlock(new BalancePrior(terms.balance_sigma), prior_loss, of_view_[v].data());
      ordering->AddElementToGroup(of_view_[v].data(), 1);
    }
    ceres_to_log();
    ceres::Solver::Options options;
    options.linear_solver_type = ceres::SPARSE_SCHUR;
    options.sparse_linear_algebra_library_type = ceres::EIGEN_SPARSE;
    options.linear_solver_ordering.reset(ordering);
    options.num_threads = 1;  // more threads would change the order of summation
    options.logging_type = ceres::SILENT;
    // Colours of points seen twice, once wrongly, converge very slowly under the second loss; the gains converge long before.
    options.max_num_iterations = 15;
    options.function_tolerance = 1e-4;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &problem, &summary);
    VITRINE_CHECK(summary.IsSolutionUsable(), "gains: {}", summary.message);
  }

  std::vector<Channel> channels_;
  std::vector<double> exposures_;               // [views] log(gain) that the prior expects
  std::vector<std::array<double, 3>> of_view_;  // log(gain) of the channels
  std::vector<Vec3d> log_colour_;               // [points]
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

// Log exposures relative to their mean; 0 where EXIF has none.
std::vector<double> expected_exposures(size_t views, std::span<const std::optional<double>> log_exposures) {
  std::vector<double> expected(views, 0);
  double sum = 0, count = 0;
  for (const std::optional<double>& e : log_exposures)
    if (e) sum += *e, count += 1;
  for (size_t v = 0; v < log_exposures.size(); ++v)
    if (log_exposures[v]) expected[v] = *log_exposures[v] - sum / count;
  return expected;
}

}  // namespace

GainSolution solve_gains(size_t view_count, size_t point_count, std::span<const GainSample> samples, const GainSettings& settings,
                         std::span<const std::optional<double>> log_exposures) {
  for (const GainSample& s : samples)
    VITRINE_CHECK(s.view < view_count && s.point < point_count, "sample of view {} and point {}", s.view, s.point);
  VITRINE_CHECK(log_exposures.empty() || log_exposures.size() == view_count, "{} exposures of {} views", log_exposures.size(),
                view_count);
  std::vector<Channel> channels;
  for (size_t c = 0; c < 3; ++c) channels.push_back(channel_of(samples, c, view_count, point_count, settings));
  Problem problem(std::move(channels), point_count, expected_exposures(view_count, log_exposures), settings);
  problem.solve();
  GainSolution solution;
  solution.gains.resize(view_count);
  for (size_t c = 0; c < 3; ++c) {
    double mean = 0;
    for (size_t v = 0; v < view_count; ++v) mean += problem.log_gain(v, c) / double(view_count);
    for (size_t v = 0; v < view_count; ++v) solution.gains[v][c] = std::exp(problem.log_gain(v, c) - mean);
    solution.samples += problem.channels()[c].observations.size();
    solution.spread = std::max(solution.spread, problem.spread(c));
  }
  for (uint32_t v = 0; v < view_count; ++v)
    if (std::any_of(problem.channels().begin(), problem.channels().end(), [&](const Channel& c) { return !c.determined[v]; }))
      solution.undetermined.push_back(v);
  solution.fixed_exposure = looks_fixed(solution.gains, settings);
  if (solution.fixed_exposure) solution.gains.assign(view_count, {1, 1, 1});
  return solution;
}

bool sample_colour(const ImageF& linear, double x, double y, int radius, Vec3f& colour) {
  const double column = std::floor(x), row = std::floor(y);
  if (!(column >= radius && row >= radius && column + radius < linear.width() && row + radius < linear.height())) return false;
  Vec3d sum;
  for (int dy = -radius; dy <= radius; ++dy) {
    for (int dx = -radius; dx <= radius; ++dx) {
      const float* p = linear.pixel(static_cast<int>(column) + dx, static_cast<int>(row) + dy);
      for (size_t c = 0; c < 3; ++c) {
        if (!(p[c] < kClipped)) return false;
        sum[c] += static_cast<double>(p[c]);
      }
    }
  }
  const double n = (2 * radius + 1) * (2 * radius + 1);
  colour = cast<float>(sum / n);
  return std::isfinite(colour.x) && std::isfinite(colour.y) && std::isfinite(colour.z);
}

std::vector<GainSample> track_samples(const ColmapModel& model, const std::function<ImageF(const ColmapImage&)>& linear_photo) {
  std::vector<std::vector<GainSample>> of_view(model.images.size());
  parallel_for(model.images.size(), 1, [&](size_t v) {
    const ColmapImage& image = model.images[v];
    const ImageF photo = linear_photo(image);
    for (const ColmapPoint2D& p : image.points) {
      if (p.point3d_id == kNoPoint3D) continue;
      const ColmapPoint3D* point = model.find_point(p.point3d_id);
      GainSample sample{static_cast<uint32_t>(v), 0, {}};
      if (!point || !sample_colour(photo, p.x, p.y, kRadius, sample.linear_rgb)) continue;
      sample.point = static_cast<uint32_t>(point - model.points.data());
      of_view[v].push_back(sample);
    }
  });
  std::vector<GainSample> samples;
  for (const std::vector<GainSample>& some : of_view) samples.insert(samples.end(), some.begin(), some.end());
  return samples;
}

}  // namespace vitrine
