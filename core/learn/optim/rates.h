// Learning rates of the attributes, from the attribute table. The position's rate is in units of the scene radius and decays
// over a run, rate(f) = rate * mean_end_factor^f; the others are constant.
#pragma once

#include <algorithm>
#include <cmath>
#include <span>

#include "core/learn/optim/adam.h"
#include "core/learn/optim/densify_rules.h"

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

// Step scale of the position of a surfel, and of its random walk, by its distance (densify_rules.h).
// `mean`: x, y, z.
inline float far_factor(const float* mean) { return far_factor(Vec3f{mean[0], mean[1], mean[2]}); }

}  // namespace vitrine
