// The optimize stage: surfels of up to three layers, trained on the photos of an sfm artifact through the image model.
//   reads   sfm (linear/*.exr, sparse/0, gains), masks and normals when there are any
//   writes  gaussians/{diffuse,reflection,transmittance,opaque}.ply, optimize/{views.json,report.json,previews/*.png}
//           optimize/trained/masks/object/*.png if only a part of the scene was trained
// An interrupted run continues from its last checkpoint and ends with the same bytes as an uninterrupted one.
#pragma once

#include <string>

#include "core/learn/loss/loss_set.h"
#include "core/learn/optim/densify.h"
#include "core/learn/optim/rates.h"
#include "stages/optimize/phases.h"
#include "stages/stage.h"

namespace vitrine {

// Fractions of the run that train at a quarter and at half of the photo size, coarse to fine.
struct ResolutionPhases {
  double quarter_until = 0.12, half_until = 0.45;
};

struct InitialConfig {
  int frustum_points = 80000;
  int stereo_side = 160;
};

enum class WantedSurroundings { Auto, Train, Ignore };

struct OptimizeConfig {
  int iterations = 3000;
  int max_gaussians = 240000;
  WantedLayers layers = WantedLayers::Auto;
  bool opaque_twin = true;
  int sh_degree = 1;
  int max_side = 1280;
  Backend backend = Backend::Cpu;
  int seed = 1;
  int holdout_every = 8;
  WantedSurroundings surroundings = WantedSurroundings::Auto;
  bool fill_unseen = true;
  int checkpoint_every = 250;
  double sh_from = 0.15;     // fraction of the run after which colour depends on the view; not an option
  int preview_every = 1000;  // steps between preview pictures, 0 = only the last; not an option
  ResolutionPhases resolution;
  InitialConfig initial;
  PhasesConfig phases;
  ShadingConfig shading;
  RatesConfig rates;
  DensifyConfig densify;
  LossSet loss;
};
void describe(Describer& d, OptimizeConfig& c);

void run_optimize(const OptimizeConfig& config, StageContext& context);
Stage optimize_stage();
StageCost optimize_cost(const CostTerms& terms);
StageReport optimize_report();

}  // namespace vitrine
