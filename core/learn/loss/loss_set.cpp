#include "core/learn/loss/loss_set.h"

#include <limits>

namespace vitrine {

void describe(Describer& d, LossSet& set) {
  for (LossTerm& term : set.terms()) {
    d.option(term.factory->name, term.schedule.weight, term.factory->doc).range(0, 1e6);
    term.loss->describe_options(d);
  }
}

LossSet::LossSet() {
  for (const LossFactory& factory : loss_registry()) {
    terms_.push_back({&factory, factory.make(), {}});
    terms_.back().schedule = {.weight = factory.default_weight,
                              .from = factory.default_from,
                              .ramp = factory.default_ramp,
                              .final_share = factory.default_final_share};
  }
}

LossSet::LossSet(const LossSet& other) : LossSet() {
  for (size_t i = 0; i < terms_.size(); ++i) {
    terms_[i].schedule = other.terms_[i].schedule;
    OptionTable own, theirs;
    Describer own_options(own), their_options(theirs);
    terms_[i].loss->describe_options(own_options);
    other.terms_[i].loss->describe_options(their_options);
    for (size_t o = 0; o < own.options.size(); ++o) own.options[o].assign(theirs.options[o].text(), theirs.options[o].origin);
  }
}

LossTerm& LossSet::term(std::string_view name) {
  for (LossTerm& term : terms_)
    if (term.factory->name == name) return term;
  VITRINE_CHECK(false, "no loss is called {}", name);
}

LossValues LossSet::evaluate(double fraction, const LossInput& input, LossGradient& gradient) const {
  LossValues values;
  for (const LossTerm& term : terms_) {
    const double weight = term.schedule.at(fraction);
    if (weight == 0) {
      values.terms.push_back(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    values.terms.push_back(term.loss->evaluate(input, weight, gradient));
    values.total += weight * values.terms.back();
  }
  return values;
}

}  // namespace vitrine
