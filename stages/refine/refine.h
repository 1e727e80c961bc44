// The refine stage: correction of the content behind glass with the mesh (algorithms 5.2, 5.3).
//   reads   sfm, optimize, mesh, masks when there are any
//   writes  refine/{report.json,segments.png}; refine/gaussians/*.ply and refine/model.json if the scene improved
// Interrupted training continues from the last checkpoint and ends with the same bytes. Every change is evaluated on held-out
// photos; a scene without improvement is unchanged.
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
