// Decompose: the colours of the diffuse and the transmittance layer taken apart into albedo and light (algorithms 7.3, "bake then
// solve"). README.md teaches the method and the options.
//   reads   sfm/{sparse,linear,gains,passes}, gaussians/*.ply, optimize/{views,model}.json, mesh/{mesh,behind_glass}.ply, masks
//   writes  decompose/{materials.ply,environment.exr,surroundings.ply,report.json,albedo.png,baked.png}
#pragma once

#include <string>

#include "stages/stage.h"

namespace vitrine {

struct DecomposeSolverConfig {
  int points = 5000;
  int rounds = 20;
  double ridge = 0.01;
  double smooth = 0.02;
  double range_sigma = 1;
  double chroma_sigma = 0.03;
};
void describe(Describer& d, DecomposeSolverConfig& c);

struct DecomposeConfig {
  int points = 60000;
  int bands = 16;
  int max_side = 320;
  int panorama_height = 64;
  double sky_distance = 0;
  double white_albedo = 0.8;
  std::string grey_card;
  double grey_albedo = 0.18;
  int sheet_rows = 4;
  int sheet_cell_width = 320;
  int seed = 1;
  DecomposeSolverConfig solver;
};
void describe(Describer& d, DecomposeConfig& c);

void run_decompose(const DecomposeConfig& config, StageContext& context);
Stage decompose_stage();
StageCost decompose_cost(const CostTerms& terms);
StageReport decompose_report();

}  // namespace vitrine
