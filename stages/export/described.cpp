#include "stages/export/export.h"

namespace vitrine {

StageCost export_cost(const CostTerms& t) {
  const double faces = t.number("mesh.faces"), surfels_k = t.number("optimize.max_gaussians") / 1000;
  return stage_cost(9 + 0.9e-4 * faces + 0.07 * surfels_k, 0.7, 560 + 1e-3 * faces, 25 + 0.25 * surfels_k + 2e-4 * faces);
}

}  // namespace vitrine
