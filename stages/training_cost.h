// Cost of training on the photos: terms shared by the estimates of several stages.
#pragma once

#include <algorithm>

#include "core/foundation/artifact/stage_cost.h"

namespace vitrine {

inline double ingested_side(const CostTerms& t) { return t.number("ingest.max_side"); }
// Total megapixels of the ingested photos.
inline double ingested_mpx(const CostTerms& t) { return t.photos() * t.mpx(ingested_side(t)); }
inline double trained_side(const CostTerms& t) { return t.limited("optimize.max_side", ingested_side(t)); }
// Of one opaque layer, CPU seconds.
inline double opaque_step_s(const CostTerms& t) {
  return 0.33 * t.mpx(trained_side(t)) + 0.60e-3 * t.number("optimize.max_gaussians") / 1000;
}
// CPU seconds of a step of training with all its layers, of which those of mirrors and glass take part in `layered` of the steps;
// a ray of them costs less than its pixel, which is shaded with all the others. `budget_option`: option with the most rays of a
// step.
inline double training_step_s(const CostTerms& t, double layered, const char* budget_option) {
  double cpu_s = opaque_step_s(t);
  if (t.capture.masks) {
    constexpr double kMaskedShare = 0.22, kRay = 5.5e-6, kLayer = 0.28;
    const double masked = kMaskedShare * t.mpx(trained_side(t)) * 1e6, budget = t.number(budget_option);
    cpu_s += layered * (kLayer + kRay * (budget > 0 ? std::min(budget, masked) : masked));
  }
  return cpu_s;
}
inline double training_memory_mib(const CostTerms& t) {
  const double mib = 140 + t.number("optimize.max_gaussians") / 1000 + 30 * t.photos() * t.mpx(trained_side(t));
  return t.capture.masks ? 1.65 * mib : mib;
}
inline double trained_surfels_disk_mib(const CostTerms& t) { return 0.2 * t.number("optimize.max_gaussians") / 1000 + 2; }

}  // namespace vitrine
