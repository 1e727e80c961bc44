// Learning rates of the attributes, from the attribute table. The position's rate is in units of the scene radius and decays
// over a run, rate(f) = rate * mean_end_factor^f; the others are constant.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "core/learn/optim/adam.h"

namespace vitrine {

struct RatesConfig {
  std::array<float, kAttributeCount> rate = [] {
    std::array<float, kAttributeCount> r{};
    for (size_t i = 0; i < kAttributeCount; ++i) r[i] = kAttributes[i].rate;
    return r;
  }();
  double factor = 1;              // of all
  double mean_end_factor = 0.02;  // of the position's rate at the end of the run, exponential decay
  double rarest = 2;              // maximum visibility step scale (SurfelAccumulator::rarity)
};

// At `fraction` of the run, for a scene of this radius.
inline AttributeRates rates_at(const RatesConfig& c, double fraction, double scene_radius) {
  AttributeRates rates{};
  const double mean_decay = std::pow(c.mean_end_factor, fraction);
  for (const AttributeRow& r : kAttributes) {
    const auto i = static_cast<size_t>(r.id);
    rates[i] = static_cast<float>(c.factor * c.rate[i] * (r.id == Attribute::Mean ? mean_decay * scene_radius : 1));
  }
  return rates;
}

// Step scale by distance: surfels far from the cameras move in proportion to their distance, so that a step, or a random walk,
// has the same angular size everywhere. 1 near the cameras, whose radius is 1 around the origin; beyond a few radii the
// distance divided by that limit.
inline float far_factor(const float* mean) {
  constexpr float kFar = 5;
  return std::max(1.f, std::sqrt(mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]) / kFar);
}

}  // namespace vitrine
