#include "core/learn/trainer/medium_training.h"

#include <algorithm>
#include <cmath>

namespace vitrine {

namespace {

constexpr double kMediumBeta1 = 0.9, kMediumBeta2 = 0.99, kMediumEpsilon = 1e-12;
constexpr double kMediumPull = 1e-4;  // gradient of the loss per unit of a logarithm's distance from its start
constexpr double kLeastNumber = 1e-6;

}  // namespace

MediumTraining::MediumTraining(MediumKind kind, const MediumCoefficients<double>& start) : kind_(kind), now_(start) {
  const Vec3d* rows[] = {&start.direct, &start.backscatter, &start.veil};
  for (size_t i = 0; i < kNumbers; ++i) log_[i] = start_[i] = std::log(std::max((*rows[i / 3])[i % 3], kLeastNumber));
}

void MediumTraining::descend(const MediumCoefficients<double>& gradient, double rate) {
  const Vec3d* const grads[] = {&gradient.direct, &gradient.backscatter, &gradient.veil};
  Vec3d* const values[] = {&now_.direct, &now_.backscatter, &now_.veil};
  Numbers grad{};
  for (size_t i = 0; i < kNumbers; ++i) {
    grad[i] = (*grads[i / 3])[i % 3] * (*values[i / 3])[i % 3];
    if (!std::isfinite(grad[i])) return;
  }
  if (kind_ == MediumKind::Haze)
    for (size_t i = 1; i < 6; ++i) grad[0] += grad[i], grad[i] = 0;
  ++steps_;
  const double c1 = 1 / (1 - std::pow(kMediumBeta1, double(steps_))), c2 = 1 / (1 - std::pow(kMediumBeta2, double(steps_)));
  for (size_t i = 0; i < kNumbers; ++i) {
    const double g = grad[i] + kMediumPull * (log_[i] - start_[i]);
    first_[i] = kMediumBeta1 * first_[i] + (1 - kMediumBeta1) * g;
    second_[i] = kMediumBeta2 * second_[i] + (1 - kMediumBeta2) * g * g;
    log_[i] -= rate * c1 * first_[i] / (std::sqrt(c2 * second_[i]) + kMediumEpsilon);
  }
  if (kind_ == MediumKind::Haze) std::fill_n(log_.begin(), 6, log_[0]);
  for (size_t i = 0; i < kNumbers; ++i) (*values[i / 3])[i % 3] = std::exp(log_[i]);
}

void MediumTraining::transfer(Archive& archive) {
  archive.value(kind_);
  archive.value(now_);
  archive.value(start_);
  archive.value(log_);
  archive.value(first_);
  archive.value(second_);
  archive.value(steps_);
}

}  // namespace vitrine
