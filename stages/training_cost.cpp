#include "stages/training_cost.h"

namespace vitrine {

double training_step_s(const CostTerms& t, double layered, const char* budget_option) {
  const double mpx = t.mpx(trained_side(t)), surfels_k = t.number("optimize.max_gaussians") / 1000;
  double cpu_s = 0.33 * mpx + 0.60e-3 * surfels_k;
  if (t.capture.masks) {
    constexpr double kMaskedShare = 0.22, kRay = 5.5e-6, kLayer = 0.28;
    const double masked = kMaskedShare * mpx * 1e6, budget = t.number(budget_option);
    cpu_s += layered * (kLayer + kRay * (budget > 0 ? std::min(budget, masked) : masked));
  }
  return cpu_s;
}

double training_memory_mib(const CostTerms& t) {
  const double mib = 140 + t.number("optimize.max_gaussians") / 1000 + 30 * t.photos() * t.mpx(trained_side(t));
  return t.capture.masks ? 1.65 * mib : mib;
}

}  // namespace vitrine
