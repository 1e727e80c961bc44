#include "core/train/shape_training.h"

#include <algorithm>
#include <cmath>
#include <span>

namespace vitrine {

namespace {

constexpr double kBeta1 = 0.9, kBeta2 = 0.99;

}  // namespace

ShapeTraining::ShapeTraining(std::vector<SurfaceOfRevolution> shapes) : shapes_(std::move(shapes)), moments_(shapes_.size()) {
  for (const SurfaceOfRevolution& s : shapes_) profile_m_.emplace_back(s.profile.size(), 0.0);
}

void ShapeTraining::descend(const std::vector<std::vector<double>>& gradients, const ShapeRates& rates) {
  for (size_t k = 0; k < shapes_.size() && k < gradients.size(); ++k) {
    const size_t n = shapes_[k].profile.size();
    std::vector<double> grad = gradients[k], move(grad.size());
    shapes_[k].smooth(grad);
    const std::span<const double> turn(grad.data(), 4), slope(grad.data() + 4, n);
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
    for (size_t i = 0; i < 4; ++i) {
      mix(m.m[i], kBeta1, turn[i]);
      move[i] = -(i < 2 ? rates.origin : rates.axis) * step(m.m[i], m.v[i / 2]);
    }
    for (size_t i = 0; i < n; ++i) {
      mix(profile_m_[k][i], kBeta1, slope[i]);
      move[4 + i] = -rates.profile * step(profile_m_[k][i], m.profile_v);
    }
    shapes_[k] = shapes_[k].moved(move);
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
