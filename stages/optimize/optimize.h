// The optimize stage: surfels of up to three layers, trained on the photos of an sfm artifact through the image model.
//   reads   sfm (linear/*.exr, sparse/0, gains), masks and normals when there are any
//   writes  gaussians/{diffuse,reflection,transmittance,opaque}.ply, optimize/{views.json,report.json,previews/*.png}
//   optimize/trained/masks/object/*.png where only a part of the photos was trained
// Interrupted at any step it continues from its last checkpoint and ends with the same bytes as an uninterrupted run.
#pragma once

#include <string>

#include "core/loss/loss_set.h"
#include "core/optim/densify.h"
#include "core/optim/rates.h"
#include "stages/optimize/phases.h"
#include "stages/stage.h"

namespace vitrine {

struct ResolutionConfig {
  int max_side = 1280;
  double quarter_until = 0.12, half_until = 0.45;
};

struct InitialConfig {
  int frustum_points = 80000;
  double far_factor = 5.0;
  int stereo_side = 160;
  double opacity = 0.3;
  double scale = 1.0;
};

struct OptimizeConfig {
  int iterations = 3000;
  int max_gaussians = 240000;
  std::string layers = "auto";
  bool opaque_twin = true;
  int sh_degree = 1;
  double sh_from = 0.15;
  std::string backend = "cpu";
  int seed = 1;
  int holdout_every = 8;
  std::string surroundings = "auto";
  bool fill_unseen = true;
  int preview_every = 1000;
  int checkpoint_every = 250;
  ResolutionConfig resolution;
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
