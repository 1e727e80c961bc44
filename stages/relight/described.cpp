// Cost estimate of the relight stage.
#include "stages/relight/relight.h"

namespace vitrine {

StageCost relight_cost(const CostTerms& t) { return stage_cost(14 + 0.2 * t.photos(), 0.77, 350 + 4 * t.photos(), 6); }

}  // namespace vitrine
