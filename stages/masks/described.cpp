// Cost estimate of the masks stage.
#include "stages/masks/masks.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost masks_cost(const CostTerms& t) {
  const double out = ingested_mpx(t);
  if (t.capture.masks) return stage_cost(0.25 * t.photos(), 0.9, 110 + 4 * out, 0.35 * out);
  return stage_cost(3.2 * t.photos(), 0.9, 160 + 3 * out + 5 * t.photos(), 0.05 * out);
}

}  // namespace vitrine
