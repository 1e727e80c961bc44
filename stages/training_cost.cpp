#include "stages/training_cost.h"

namespace vitrine {

double opaque_step_s(const CostTerms& t) {
  return 0.33 * t.mpx(trained_side(t)) + 0.60e-3 * t.number("optimize.max_gaussians") / 1000;
}

double training_step_s(const CostTerms& t, double layered, const char* budget_option) {
  double cpu_s = opaque_step_s(t);
  if (t.capture.masks) {
    constexpr double kMaskedShare = 0.22, kRay = 5.5e-6, kLayer = 0.28;
    const double masked = kMaskedShare * t.mpx(trained_side(t)) * 1e6, budget = t.number(budget_option);
    cpu_s += layered * (kLayer + kRay * (budget > 0 ? std::min(budget, masked) : masked));
  }
  return cpu_s;
}

double training_memory_mib(const CostTerms& t) {
  const double mib = 140 + t.number("optimize.max_gaussians") / 1000 + 30 * t.photos() * t.mpx(trained_side(t));
  return t.capture.masks ? 1.65 * mib : mib;
}

}  // namespace vitrine
