#include "core/train/shape_training.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vitrine {

namespace {

constexpr double kBeta1 = 0.9, kBeta2 = 0.99;
constexpr int kMixing = 6;  // passes of 1 2 1 over the gradient of the profile

std::array<Vec3d, 2> across(const Vec3d& axis) {
  const Vec3d u = normalized(cross(axis, std::abs(axis.x) < 0.9 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
  return {u, cross(axis, u)};
}

// Where a corner may go: along its normal; on the axis, along that.
std::vector<Vec2d> ways(const TurnedSurface& s) {
  std::vector<Vec2d> out = s.corner_normals();
  for (size_t i = 0; i < out.size(); ++i) {
    const double l = std::hypot(out[i].x, out[i].y);
    out[i] = l > 0 ? Vec2d{out[i].x / l, out[i].y / l} : Vec2d{};
  }
  for (const size_t end : {size_t(0), out.size() - 1})
    if (s.profile[end].x <= 0) out[end] = {0, end == 0 ? -1. : 1.};
  return out;
}

}  // namespace

ShapeTraining::ShapeTraining(std::vector<TurnedSurface> shapes) : shapes_(std::move(shapes)), moments_(shapes_.size()) {
  for (const TurnedSurface& s : shapes_) profile_m_.emplace_back(s.profile.size(), 0.0);
}

void ShapeTraining::descend(const std::vector<TurnedGradient>& gradients, const ShapeRates& rates) {
  for (size_t k = 0; k < shapes_.size() && k < gradients.size(); ++k) {
    TurnedSurface& s = shapes_[k];
    const TurnedGradient& g = gradients[k];
    const size_t n = s.profile.size();
    const std::array<Vec3d, 2> sides = across(s.axis);
    const std::vector<Vec2d> way = ways(s);
    std::vector<double> slope(n);
    for (size_t i = 0; i < n; ++i) slope[i] = g.profile[i].x * way[i].x + g.profile[i].y * way[i].y;
    for (int pass = 0; pass < kMixing; ++pass) {
      const std::vector<double> before = slope;
      for (size_t i = 0; i < n; ++i) slope[i] = (before[i > 0 ? i - 1 : 0] + 2 * before[i] + before[i + 1 < n ? i + 1 : i]) / 4;
    }
    const double turn[4] = {dot(g.origin, sides[0]), dot(g.origin, sides[1]), dot(g.axis, sides[0]), dot(g.axis, sides[1])};
    double squares[3] = {};
    for (size_t i = 0; i < 4; ++i) squares[i / 2] += turn[i] * turn[i] / 2;
    for (double v : slope) squares[2] += v * v / double(n);
    if (!std::isfinite(squares[0] + squares[1] + squares[2]) || squares[0] == 0) continue;  // the picture does not show it

    Moments& m = moments_[k];
    ++m.steps;
    const double c1 = 1 / (1 - std::pow(kBeta1, double(m.steps))), c2 = 1 / (1 - std::pow(kBeta2, double(m.steps)));
    const auto mix = [](double& moment, double beta, double value) { moment = beta * moment + (1 - beta) * value; };
    mix(m.v[0], kBeta2, squares[0]), mix(m.v[1], kBeta2, squares[1]), mix(m.profile_v, kBeta2, squares[2]);
    const auto step = [&](double moment, double v) { return v > 0 ? moment * c1 / std::sqrt(v * c2) : 0; };
    for (size_t i = 0; i < 4; ++i) mix(m.m[i], kBeta1, turn[i]);
    for (size_t i = 0; i < 2; ++i) {
      s.origin += (-rates.origin * step(m.m[i], m.v[0])) * sides[i];
      s.axis += (-rates.axis * step(m.m[2 + i], m.v[1])) * sides[i];
    }
    s.axis = normalized(s.axis);
    for (size_t i = 0; i < n; ++i) {
      mix(profile_m_[k][i], kBeta1, slope[i]);
      const double by = -rates.profile * step(profile_m_[k][i], m.profile_v);
      s.profile[i] = {std::max(s.profile[i].x + by * way[i].x, 0.0), s.profile[i].y + by * way[i].y};
    }
  }
}

void ShapeTraining::save(ArchiveWriter& out) const {
  out.value(static_cast<uint64_t>(shapes_.size()));
  for (size_t k = 0; k < shapes_.size(); ++k) {
    out.value(shapes_[k].origin);
    out.value(shapes_[k].axis);
    out.array(std::span<const Vec2d>(shapes_[k].profile));
    out.array(std::span<const double>(profile_m_[k]));
    out.value(moments_[k]);
  }
}

void ShapeTraining::load(ArchiveReader& in) {
  uint64_t count = 0;
  in.value(count);
  shapes_.clear(), moments_.clear(), profile_m_.clear();
  for (uint64_t k = 0; k < count; ++k) {
    in.value(shapes_.emplace_back().origin);
    in.value(shapes_[k].axis);
    in.array(shapes_[k].profile);
    in.array(profile_m_.emplace_back());
    in.value(moments_.emplace_back());
    profile_m_[k].resize(shapes_[k].profile.size());
  }
}

}  // namespace vitrine
