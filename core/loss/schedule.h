// When a loss counts: its weight, the part of the run in which it is on, and a linear ramp at the start. Times are fractions
// of the run in [0, 1], so that presets of different length share them.
#pragma once

#include <algorithm>

#include "core/config/describe.h"

namespace vitrine {

struct WeightSchedule {
  float weight = 0;
  double from = 0, until = 1, ramp = 0;

  float at(double fraction) const {
    if (weight == 0 || fraction < from || fraction > until) return 0;
    return ramp > 0 ? weight * static_cast<float>(std::min(1.0, (fraction - from) / ramp)) : weight;
  }
};

inline void describe(Describer& d, WeightSchedule& s) {
  d.option("weight", s.weight, "Weight of this loss in the sum; 0 switches it off.").range(0, 1e6);
  d.option("from", s.from, "Part of the run after which it counts.").range(0, 1);
  d.option("until", s.until, "Part of the run after which it no longer counts.").range(0, 1);
  d.option("ramp", s.ramp, "Part of the run over which the weight rises from zero.").range(0, 1);
}

}  // namespace vitrine
