#include "stages/decompose/light_solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include <Eigen/Dense>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/quantile.h"

namespace vitrine {

namespace {

constexpr float kPi = std::numbers::pi_v<float>;
constexpr float kDarkest = 1e-4f;     // lower bound of radiance and irradiance
constexpr int kSweeps = 40;           // of the coordinate descent
constexpr double kPercentile = 0.95;  // of the albedos that become white
constexpr float kLeastOpen = 1e-3f;   // mean of A below which no point receives light from a cell

// Relative to the mean diagonal of the normal matrix.
constexpr float kRidge = 0.01f;   // regularisation of each cell towards the mean light
constexpr float kSmooth = 0.02f;  // regularisation of the difference between neighbouring cells
constexpr float kRangeSigma = 1;  // in log albedo: much larger differences mean different paint

using Matrix = Eigen::MatrixXf;
using Vector = Eigen::VectorXf;

class Solver {
 public:
  Solver(const LightProblem& problem, const LightSolverDesc& desc) : p_(problem), d_(desc), count_(problem.chosen.size()) {
    const LightGrid& grid = p_.transport.grid;
    std::vector<double> open(grid.cells(), 0);
    for (const uint32_t s : p_.chosen)
      for (size_t j = 0; j < grid.cells(); ++j) open[j] += p_.transport.row(s)[j];
    place_.assign(grid.cells(), kNone);
    for (size_t j = 0; j < grid.cells(); ++j)
      if (open[j] > double(kLeastOpen * grid.solid_angle()) * double(count_)) {
        place_[j] = cell_.size();
        cell_.push_back(j);
        share_.push_back(open[j]);
      }
    a_.resize(Eigen::Index(count_), Eigen::Index(cell_.size()));
    for (size_t s = 0; s < count_; ++s)
      for (size_t f = 0; f < cell_.size(); ++f) a_(Eigen::Index(s), Eigen::Index(f)) = p_.transport.row(p_.chosen[s])[cell_[f]];
    for (size_t c = 0; c < 3; ++c) {
      known_[c].resize(Eigen::Index(count_));
      radiance_[c].resize(Eigen::Index(count_));
      light_[c] = Vector::Ones(Eigen::Index(cell_.size()));
      for (size_t s = 0; s < count_; ++s) {
        known_[c](Eigen::Index(s)) = p_.transport.known[p_.chosen[s]][c];
        radiance_[c](Eigen::Index(s)) = std::max(kDarkest, p_.points[p_.chosen[s]].radiance[c]);
      }
    }
  }

  LightSolution run() {
    LightSolution out;
    if (!cell_.empty()) {
      set_scale(out);
      for (int round = 0; round < d_.rounds; ++round) {
        average_albedo(out);
        for (size_t c = 0; c < 3; ++c) solve_channel(c);
        set_scale(out);
      }
    }
    average_albedo(out);
    out.light.assign(p_.transport.grid.cells(), Vec3f{});
    out.free.assign(p_.transport.grid.cells(), false);
    for (size_t f = 0; f < cell_.size(); ++f) {
      out.free[cell_[f]] = true;
      for (size_t c = 0; c < 3; ++c) out.light[cell_[f]][c] = light_[c](Eigen::Index(f));
    }
    double known = 0, all = 0;
    for (size_t c = 0; c < 3; ++c) known += known_[c].sum(), all += irradiance(c).sum();
    out.known_share = all > 0 ? known / all : 1;
    return out;
  }

 private:
  static constexpr size_t kNone = ~size_t(0);

  Vector irradiance(size_t c) const { return (a_ * light_[c] + known_[c]).cwiseMax(kDarkest); }

  // (a) Writes the logarithms to average_.
  void average_albedo(LightSolution& out) {
    std::array<Vector, 3> log_rho;
    for (size_t c = 0; c < 3; ++c) {
      const Vector e = irradiance(c);
      log_rho[c] = (kPi * radiance_[c].array() / e.array()).log().matrix();
      average_[c].resize(Eigen::Index(count_));
    }
    const float inverse = 1 / (2 * kRangeSigma * kRangeSigma);
    parallel_for(count_, 256, [&](size_t s) {
      const auto i = Eigen::Index(s);
      Vec3f sum{log_rho[0](i), log_rho[1](i), log_rho[2](i)};
      const Vec3f own = sum;
      float weight = 1;
      for (const Affinity::Partner& partner : p_.affinity.of(s)) {
        const auto j = Eigen::Index(partner.point);
        const Vec3f other{log_rho[0](j), log_rho[1](j), log_rho[2](j)};
        const float w = partner.weight * std::exp(-inverse * squared_length(other - own) / 3);
        sum += w * other;
        weight += w;
      }
      for (size_t c = 0; c < 3; ++c) average_[c](i) = sum[c] / weight;
    });
    double squares = 0;
    for (size_t c = 0; c < 3; ++c) squares += double((log_rho[c] - average_[c]).squaredNorm());
    out.misfit.push_back(std::sqrt(squares / (3.0 * double(count_))));
  }

  // (b) Solves for the light of one channel.
  void solve_channel(size_t c) {
    const Eigen::Index cells = Eigen::Index(cell_.size());
    const Vector q = (average_[c].array().exp() / (kPi * radiance_[c].array())).matrix();
    const Matrix scaled = q.asDiagonal() * a_;
    Matrix h(cells, cells);
    h.setZero();
    h.selfadjointView<Eigen::Lower>().rankUpdate(scaled.transpose(), 1.f / float(count_));
    h.triangularView<Eigen::Upper>() = h.transpose();
    const Vector wanted = (1.f - q.array() * known_[c].array()).matrix();
    Vector b = scaled.transpose() * wanted / float(count_);
    const float unit = h.diagonal().mean(), ridge = kRidge * unit, smooth = kSmooth * unit;
    const float mean = light_[c].mean();
    for (Eigen::Index f = 0; f < cells; ++f) {
      h(f, f) += ridge;
      b(f) += ridge * mean;
    }
    const LightGrid& grid = p_.transport.grid;
    for (size_t f = 0; f < cell_.size(); ++f)
      for (const size_t neighbour : {grid.east(cell_[f]), grid.south(cell_[f])}) {
        if (neighbour >= grid.cells() || place_[neighbour] == kNone) continue;
        const auto i = Eigen::Index(f), j = Eigen::Index(place_[neighbour]);
        h(i, i) += smooth, h(j, j) += smooth, h(i, j) -= smooth, h(j, i) -= smooth;
      }
    // Coordinate descent keeps L >= 0 exactly, and its fixed order makes it reproducible.
    Vector& l = light_[c];
    Vector gradient = h * l - b;
    for (int sweep = 0; sweep < kSweeps; ++sweep)
      for (Eigen::Index f = 0; f < cells; ++f) {
        const float next = std::max(0.f, l(f) - gradient(f) / h(f, f)), step = next - l(f);
        if (step == 0) continue;
        l(f) = next;
        gradient += step * h.col(f);
      }
  }

  // (c) Sets the scale.
  void set_scale(LightSolution& out) {
    // White: the channel means, weighted by the visibility of the cells.
    std::array<double, 3> mean{};
    double weight = 0;
    for (size_t f = 0; f < cell_.size(); ++f) {
      weight += share_[f];
      for (size_t c = 0; c < 3; ++c) mean[c] += share_[f] * double(light_[c](Eigen::Index(f)));
    }
    const double grey = (mean[0] + mean[1] + mean[2]) / 3;
    for (size_t c = 0; c < 3; ++c)
      if (mean[c] > 1e-9 * weight) light_[c] *= float(grey / mean[c]);
    // Albedo decreases monotonically with the light: bisection in the logarithm of the scale.
    std::array<Vector, 3> open;
    for (size_t c = 0; c < 3; ++c) open[c] = a_ * light_[c];
    std::vector<float> rho(count_);
    const auto white_at = [&](float gain) {
      for (size_t s = 0; s < count_; ++s) {
        Vec3f r;
        const auto i = Eigen::Index(s);
        for (size_t c = 0; c < 3; ++c) r[c] = kPi * radiance_[c](i) / std::max(kDarkest, gain * open[c](i) + known_[c](i));
        rho[s] = luminance(r);
      }
      return quantile_of(rho, kPercentile);
    };
    float low = 1e-3f, high = 1e3f;
    out.scale_by_bounces = white_at(low) < d_.white;
    for (int step = 0; step < 40; ++step) {
      const float middle = std::sqrt(low * high);
      (white_at(middle) > d_.white ? low : high) = middle;
    }
    for (size_t c = 0; c < 3; ++c) light_[c] *= std::sqrt(low * high);
  }

  const LightProblem& p_;
  const LightSolverDesc& d_;
  size_t count_;
  std::vector<size_t> place_, cell_;
  std::vector<double> share_;
  Matrix a_;
  std::array<Vector, 3> known_, radiance_, light_, average_;
};

}  // namespace

float luminance(const Vec3f& rgb) { return 0.2126f * rgb.x + 0.7152f * rgb.y + 0.0722f * rgb.z; }

LightSolution solve_light(const LightProblem& problem, const LightSolverDesc& desc) { return Solver(problem, desc).run(); }

ImageF environment_map(const Surroundings& around, const LightGrid& grid, const LightSolution& solution, const Vec3f& unit) {
  const int h = around.height;
  ImageF out(2 * h, h, 3);
  Vec3d sum{};
  double count = 0;
  for (size_t j = 0; j < solution.light.size(); ++j)
    if (solution.free[j]) sum += cast<double>(solution.light[j]), count += 1;
  const Vec3f mean = count > 0 ? cast<float>(sum / count) : Vec3f{};
  for (size_t t = 0; t < out.pixel_count(); ++t) {
    const size_t cell = grid.cell_of(around.direction(t));
    Vec3f value = solution.free[cell] ? solution.light[cell] : mean;
    if (around.seen(t))
      for (size_t c = 0; c < 3; ++c) value[c] = around.radiance[t][c] / unit[c];
    for (size_t c = 0; c < 3; ++c) out.data()[3 * t + c] = value[c];
  }
  return out;
}

}  // namespace vitrine
