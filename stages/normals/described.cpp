// Cost estimate of the normals stage.
#include "stages/normals/normals.h"
#include "stages/training_cost.h"

namespace vitrine {

StageCost normals_cost(const CostTerms& t) {
  const double out = t.photos() * t.mpx(t.limited("normals.max_side", ingested_side(t)));
  const double stereo = t.photos() * t.mpx(t.limited("normals.geometric.max_side", ingested_side(t)));
  return stage_cost(0.6 * t.photos() + 22 * stereo, 0.95, 90 + 4 * out, 1.2 * out);
}

}  // namespace vitrine
