#include "stages/optimize/medium_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/pattern_search.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

constexpr size_t kLeftOutEvery = 4;         // of the photos
constexpr double kRobustResidual = 0.05;    // residuals beyond have little weight, relative to the noise below
constexpr double kDark = 0.05;              // linear; the noise of a sample is proportional to sqrt(I + kDark)
constexpr double kLeastCoefficient = 1e-3;  // of all coefficients
// Score per sample and squared log of b_B / b_D. Of light of one wavelength both are the same number.
constexpr double kMediumTie = 1e-2;
constexpr int kReweightings = 2;

// One channel of one sample.
struct MediumValue {
  double z, y, noise;  // distance, radiance, relative standard deviation
  bool kept;           // false: of a left-out photo
};
struct MediumPoint {
  size_t begin, end;  // samples
};

double robust_cost(double residual) { return std::log1p(residual * residual / (kRobustResidual * kRobustResidual)); }
double robust_weight(double residual) { return 1 / (1 + residual * residual / (kRobustResidual * kRobustResidual)); }

struct MediumSolution {
  double veil = 0;
  double cost = 0;           // mean of the kept samples
  double left_out_cost = 0;  // mean of the others, for points with at least two kept samples
};

// Radiances of the points and the veil for given coefficients; b_D = b_B = 0 is a scene in air.
class MediumChannel {
 public:
  MediumChannel(std::span<const MediumSample> samples, std::span<const MediumPoint> points, std::span<const DarkLevel> dark,
                size_t channel, size_t left_out)
      : points_(points), dark_(dark), channel_(channel) {
    for (const MediumSample& s : samples) {
      const double y = double(s.linear[channel]);
      values_.push_back(
          {double(s.distance), y, std::sqrt(y + kDark), left_out == kLeftOutEvery || s.photo % kLeftOutEvery != left_out});
    }
  }

  MediumSolution solved(double direct, double backscatter) const {
    std::vector<double> d(values_.size()), s(values_.size()), w(values_.size());
    for (size_t i = 0; i < values_.size(); ++i) {
      d[i] = std::exp(-direct * values_[i].z), s[i] = 1 - std::exp(-backscatter * values_[i].z);
      w[i] = values_[i].kept ? 1 / (values_[i].noise * values_[i].noise) : 0;
    }
    MediumSolution out;
    for (int pass = 0;; ++pass) {
      out = {.veil = backscatter > 0 ? std::min(veil(d, s, w), brightest_veil(backscatter)) : 0};
      size_t kept = 0, left_out = 0;
      for (const MediumPoint& p : points_) {
        const auto [clear, count] = radiance(p, d, s, w, out.veil);
        for (size_t i = p.begin; i < p.end; ++i) {
          const MediumValue& v = values_[i];
          const double residual = (v.y - clear * d[i] - out.veil * s[i]) / v.noise;
          if (v.kept) {
            out.cost += robust_cost(residual), ++kept;
            if (pass < kReweightings) w[i] = robust_weight(residual) / (v.noise * v.noise);
          } else if (count >= 2) {
            out.left_out_cost += robust_cost(residual), ++left_out;
          }
        }
      }
      if (kept > 0) out.cost /= double(kept);
      if (left_out > 0) out.left_out_cost /= double(left_out);
      if (pass == kReweightings) return out;
    }
  }

 private:
  // Least squares over all points, their radiances eliminated.
  double veil(const std::vector<double>& d, const std::vector<double>& s, const std::vector<double>& w) const {
    double top = 0, bottom = 0;
    for (const MediumPoint& p : points_) {
      double dd = 0, ds = 0, dy = 0, ss = 0, sy = 0;
      for (size_t i = p.begin; i < p.end; ++i) {
        dd += w[i] * d[i] * d[i], ds += w[i] * d[i] * s[i], dy += w[i] * d[i] * values_[i].y;
        ss += w[i] * s[i] * s[i], sy += w[i] * s[i] * values_[i].y;
      }
      if (!(dd > 0)) continue;
      top += sy - ds * dy / dd;
      bottom += ss - ds * ds / dd;
    }
    return bottom > 0 ? std::clamp(top / bottom, 0.0, 1.0) : 0;
  }
  double brightest_veil(double backscatter) const {
    double most = 1;
    for (const DarkLevel& level : dark_)
      most = std::min(most, level.linear[channel_] / -std::expm1(-backscatter * level.distance[channel_]));
    return most;
  }
  std::pair<double, size_t> radiance(const MediumPoint& p, const std::vector<double>& d, const std::vector<double>& s,
                                     const std::vector<double>& w, double veil) const {
    double top = 0, bottom = 0;
    size_t count = 0;
    for (size_t i = p.begin; i < p.end; ++i) {
      top += w[i] * d[i] * (values_[i].y - veil * s[i]), bottom += w[i] * d[i] * d[i];
      count += values_[i].kept;
    }
    return {bottom > 0 ? std::max(top / bottom, 0.0) : 0, count};
  }

  std::span<const MediumPoint> points_;
  std::span<const DarkLevel> dark_;
  size_t channel_;
  std::vector<MediumValue> values_;
};

using Logs = std::array<double, 2>;  // of b_D, b_B

// Best coefficients of some channels that share them. `scale`: median distance.
Logs searched(std::span<const MediumChannel> channels, bool one_coefficient, double scale) {
  const auto score = [&](const Logs& x) {
    double sum = 0;
    for (const MediumChannel& c : channels) sum -= c.solved(std::exp(x[0]), std::exp(x[1])).cost;
    const double apart = x[1] - x[0];
    return sum / double(channels.size()) - kMediumTie * apart * apart;
  };
  Logs best{};
  double best_score = -1e300;
  for (const double depth : {0.02, 0.06, 0.15, 0.35, 0.7, 1.3, 2.2})
    for (const double ratio : {0.5, 1.0, 2.0}) {
      if (one_coefficient && ratio != 1) continue;
      const Logs x{std::log(depth / scale), std::log(ratio * depth / scale)};
      if (const double s = score(x); s > best_score) best = x, best_score = s;
    }
  constexpr std::array<size_t, 2> kBoth{0, 1};
  const double least = std::log(kLeastCoefficient / scale), most = std::log(8 / scale);
  const auto move = [&](const Logs& x, size_t number, double step) -> std::optional<Logs> {
    Logs out = x;
    out[number] += step;
    if (one_coefficient) out[1 - number] += step;
    for (const double v : out)
      if (v < least || v > most) return std::nullopt;
    return out;
  };
  pattern_search(score, move, {.first = 0.4, .last = 0.01}, std::span(kBoth).first(one_coefficient ? 1 : 2), best);
  return best;
}

struct Coefficients {
  MediumCoefficients<double> medium;
  double left_out = 0, left_out_in_air = 0;  // summed over the channels
};

// `left_out`: of kLeftOutEvery; that number itself leaves out none.
Coefficients fitted(std::span<const MediumSample> samples, std::span<const MediumPoint> points, std::span<const DarkLevel> dark,
                    MediumKind kind, size_t left_out, double scale) {
  std::vector<MediumChannel> channels;
  for (size_t c = 0; c < 3; ++c) channels.emplace_back(samples, points, dark, c, left_out);
  std::array<Logs, 3> found{};
  if (kind == MediumKind::Haze)
    found.fill(searched(channels, true, scale));
  else
    parallel_for(3, 1, [&](size_t c) { found[c] = searched(std::span(channels).subspan(c, 1), false, scale); });
  Coefficients out;
  for (size_t c = 0; c < 3; ++c) {
    const MediumSolution s = channels[c].solved(std::exp(found[c][0]), std::exp(found[c][1]));
    out.medium.direct[c] = std::exp(found[c][0]);
    out.medium.backscatter[c] = std::exp(found[c][1]);
    out.medium.veil[c] = std::max(s.veil, kLeastCoefficient);
    out.left_out += s.left_out_cost;
    out.left_out_in_air += channels[c].solved(0, 0).left_out_cost;
  }
  return out;
}

}  // namespace

std::optional<MediumFit> fitted_medium(std::span<const MediumSample> samples, MediumKind kind, std::span<const DarkLevel> dark) {
  std::vector<MediumPoint> points;
  std::vector<double> distances;
  for (size_t i = 0; i < samples.size(); ++i) {
    distances.push_back(double(samples[i].distance));
    if (i == 0 || samples[i].point != samples[i - 1].point) points.push_back({i, i});
    points.back().end = i + 1;
  }
  if (points.size() < kFewestMediumPoints) return std::nullopt;
  const double scale = median(distances);
  MediumFit fit;
  fit.points = points.size();
  double error = 0, in_air = 0;
  for (size_t part = 0; part < kLeftOutEvery; ++part) {
    const Coefficients c = fitted(samples, points, dark, kind, part, scale);
    error += c.left_out, in_air += c.left_out_in_air;
  }
  fit.gain = in_air > 0 ? 1 - error / in_air : 0;
  fit.medium = fitted(samples, points, dark, kind, kLeftOutEvery, scale).medium;
  for (size_t c = 0; c < 3; ++c) fit.depth = std::max(fit.depth, fit.medium.direct[c] * scale);
  return fit;
}

}  // namespace vitrine
