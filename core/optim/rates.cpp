#include "core/optim/rates.h"

namespace vitrine {

void describe(Describer& d, RatesConfig& c) {
  for (const AttributeRow& r : kAttributes)
    d.option(
         r.name, c.rate[static_cast<size_t>(r.id)],
         r.id == Attribute::Mean ? "Adam step size of the position, times the scene radius." : "Adam step size of the raw value.")
        .range(0, 1);
  d.option("mean_end_factor", c.mean_end_factor,
           "Position rate at the end of the run, relative to its start (exponential decay).")
      .range(1e-6, 1);
  d.option("end_factor", c.end_factor, "The other rates at the end of the run, relative to their start (exponential decay).")
      .range(1e-6, 1);
  d.option("rarest", c.rarest,
           "What fewer photos than the mean show is learnt in fewer steps; these are longer in that proportion, at most by this.")
      .range(1, 100);
}

AttributeRates rates_at(const RatesConfig& c, double fraction, double scene_radius) {
  AttributeRates rates{};
  const double decay = std::pow(c.end_factor, fraction), mean_decay = std::pow(c.mean_end_factor, fraction);
  for (const AttributeRow& r : kAttributes) {
    const auto i = static_cast<size_t>(r.id);
    rates[i] = static_cast<float>(c.rate[i] * (r.id == Attribute::Mean ? mean_decay * scene_radius : decay));
  }
  return rates;
}

}  // namespace vitrine
