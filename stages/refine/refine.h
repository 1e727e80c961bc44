// The refine stage: what stands behind glass, put in order with the help of the mesh (algorithms 5.2, 5.3).
//   reads   sfm, optimize, mesh, masks when there are any
//   writes  refine/{report.json,segments.png}; where the scene became better refine/gaussians/*.ply and refine/model.json
// Interrupted while it trains it continues from its last checkpoint and ends with the same bytes. Every change is measured on the
// photos that training never saw; a scene that does not gain by it stays as it is.
#pragma once

#include <string>

#include "stages/refine/fine_tune.h"
#include "stages/stage.h"

namespace vitrine {

enum class ExteriorSet { Auto, Transmittance, Diffuse };
enum class GlassKind { Auto, Thin, Thick };

struct RefineConfig {
  int max_side = 0;
  ExteriorSet exterior_set = ExteriorSet::Auto;
  GlassKind glass = GlassKind::Auto;
  double ior = 1.5;
  FineTuneConfig fine_tune;
};
void describe(Describer& d, RefineConfig& c);

void run_refine(const RefineConfig& config, StageContext& context);
Stage refine_stage();
StageCost refine_cost(const CostTerms& terms);
StageReport refine_report();

}  // namespace vitrine
