// All losses of the registry with their schedules: the sum that an optimisation descends, and its options.
#pragma once

#include <memory>
#include <vector>

#include "core/loss/loss.h"
#include "core/loss/schedule.h"

namespace vitrine {

struct LossTerm {
  const LossFactory* factory = nullptr;
  std::unique_ptr<Loss> loss;
  WeightSchedule schedule;
};
void describe(Describer& d, LossTerm& term);

struct LossValues {
  double total = 0;           // weighted sum
  std::vector<double> terms;  // unweighted, in registry order; NaN when the term was off
};

// Options point into the terms: do not move a set after it was described.
class LossSet {
 public:
  LossSet();
  std::vector<LossTerm>& terms() { return terms_; }
  const std::vector<LossTerm>& terms() const { return terms_; }
  LossTerm& term(std::string_view name);
  // Adds the weighted gradients of all losses that are on at `fraction` of the run.
  LossValues evaluate(double fraction, const LossInput& input, LossGradient& gradient) const;

 private:
  std::vector<LossTerm> terms_;
};
void describe(Describer& d, LossSet& set);

}  // namespace vitrine
