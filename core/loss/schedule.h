// When a loss counts: its weight, the part of the run in which it is on, a linear ramp at the start, and along half a cosine
// from the ramp's end to `until` a fall to `final_share` of the weight. Times are fractions of the run in [0, 1], so that
// presets of different length share them.
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/config/describe.h"

namespace vitrine {

struct WeightSchedule {
  float weight = 0;
  double from = 0, until = 1, ramp = 0, final_share = 1;

  float at(double fraction) const {
    if (weight == 0 || fraction < from || fraction > until) return 0;
    if (fraction < from + ramp) return weight * static_cast<float>((fraction - from) / ramp);
    if (final_share == 1 || until <= from + ramp) return weight;
    const double done = (fraction - from - ramp) / (until - from - ramp);
    return weight * static_cast<float>(final_share + (1 - final_share) * 0.5 * (1 + std::cos(std::numbers::pi * done)));
  }
};

inline void describe(Describer& d, WeightSchedule& s) {
  d.option("weight", s.weight, "Weight of this loss in the sum; 0 switches it off.").range(0, 1e6);
  d.option("from", s.from, "Part of the run after which it counts.").range(0, 1);
  d.option("until", s.until, "Part of the run after which it no longer counts.").range(0, 1);
  d.option("ramp", s.ramp, "Part of the run over which the weight rises from zero.").range(0, 1);
  d.option("final_share", s.final_share, "Share of the weight that is left at `until`, reached along a cosine.").range(0, 1);
}

}  // namespace vitrine
