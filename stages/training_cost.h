// Cost of training on the photos: terms shared by the estimates of several stages.
#pragma once

#include "core/foundation/artifact/stage_cost.h"

namespace vitrine {

inline double ingested_side(const CostTerms& t) { return t.number("ingest.max_side"); }
// Total megapixels of the ingested photos.
inline double ingested_mpx(const CostTerms& t) { return t.photos() * t.mpx(ingested_side(t)); }
inline double trained_side(const CostTerms& t) { return t.limited("optimize.max_side", ingested_side(t)); }
double opaque_step_s(const CostTerms& t);  // of one opaque layer, CPU seconds
// CPU seconds of a step of training with all its layers, of which those of mirrors and glass take part in `layered` of the steps;
// a ray of them costs less than its pixel, which is shaded with all the others. `budget`: option with the most rays of a step.
double training_step_s(const CostTerms& t, double layered, const char* budget);
double training_memory_mib(const CostTerms& t);
inline double trained_surfels_disk_mib(const CostTerms& t) { return 0.2 * t.number("optimize.max_gaussians") / 1000 + 2; }

}  // namespace vitrine
