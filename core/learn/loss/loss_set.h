// Weighted sum of all losses of the registry with their schedules: the objective of a training, and the options of its weights.
#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

#include "core/learn/loss/loss.h"

namespace vitrine {

// Weight of a loss over a run: 0 before `from`, a linear ramp, then half a cosine down to `final_share` of the weight at the
// end. Times are fractions of the run in [0, 1], so that presets of different length can share them.
struct WeightSchedule {
  float weight = 0;
  double from = 0, ramp = 0, final_share = 1;

  float at(double fraction) const {
    if (weight == 0 || fraction < from) return 0;
    if (fraction < from + ramp) return weight * static_cast<float>((fraction - from) / ramp);
    if (final_share == 1 || from + ramp >= 1) return weight;
    const double done = (fraction - from - ramp) / (1 - from - ramp);
    return weight * static_cast<float>(final_share + (1 - final_share) * 0.5 * (1 + std::cos(std::numbers::pi * done)));
  }
};

struct LossTerm {
  const LossFactory* factory = nullptr;
  std::unique_ptr<Loss> loss;
  WeightSchedule schedule;
};

struct LossValues {
  double total = 0;           // weighted sum
  std::vector<double> terms;  // unweighted, in registry order; NaN when the term was off
};

// Options point into the terms: do not move a set after describing it.
class LossSet {
 public:
  LossSet();
  // The same weights, schedules and options; losses keep no state between steps.
  LossSet(const LossSet& other);
  LossSet& operator=(const LossSet&) = delete;
  std::vector<LossTerm>& terms() { return terms_; }
  const std::vector<LossTerm>& terms() const { return terms_; }
  LossTerm& term(std::string_view name);
  // Adds the weighted gradients of all losses that are active at `fraction` of the run.
  LossValues evaluate(double fraction, const LossInput& input, LossGradient& gradient) const;

 private:
  std::vector<LossTerm> terms_;
};
void describe(Describer& d, LossSet& set);

}  // namespace vitrine
