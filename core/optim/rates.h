// Step sizes of the attributes, from the attribute table, and how they shrink over a run: rate(f) = rate * end_factor^f.
// The mean's rate is in units of the scene radius and has its own end factor; the others usually stay.
#pragma once

#include <cmath>
#include <span>

#include "core/config/describe.h"
#include "core/optim/adam.h"

namespace vitrine {

struct RatesConfig {
  std::array<float, kAttributeCount> rate = [] {
    std::array<float, kAttributeCount> r{};
    for (size_t i = 0; i < kAttributeCount; ++i) r[i] = kAttributes[i].rate;
    return r;
  }();
  double mean_end_factor = 0.02, end_factor = 1;
  double rarest = 2;
};

void describe(Describer& d, RatesConfig& c);
// At `fraction` of the run, for a scene of this radius.
AttributeRates rates_at(const RatesConfig& c, double fraction, double scene_radius);

}  // namespace vitrine
