// The decompose stage: separation of the colours of the diffuse and transmittance layers into albedo and light (algorithms 7.3,
// "bake then solve"). README.md documents the method and the options.
//   reads   sfm/{sparse,linear,gains,passes}, gaussians/*.ply, optimize/{views,model}.json, mesh/{mesh,behind_glass}.ply, masks
//   writes  decompose/{materials.ply,environment.exr,surroundings.ply,report.json,albedo.png,baked.png}
#pragma once

#include <string>

#include "stages/stage.h"

namespace vitrine {

struct DecomposeConfig {
  int points = 60000;
  int panorama_height = 64;
  double sky_distance = 0;
  double white_albedo = 0.8;
  std::string grey_card;
  double grey_albedo = 0.18;
  int seed = 1;
  // Not options; tests set them.
  int bands = 16;            // light cells from zenith to nadir; twice as many azimuths
  int max_side = 320;        // longest side of the pictures that surface points are sampled from, pixels
  int sheet_rows = 4;        // views on albedo.png and baked.png
  int solver_points = 5000;  // surface points used to solve for the light
  int solver_rounds = 20;    // alternations of albedo and light
};
void describe(Describer& d, DecomposeConfig& c);

void run_decompose(const DecomposeConfig& config, StageContext& context);
Stage decompose_stage();
StageCost decompose_cost(const CostTerms& terms);
StageReport decompose_report();

}  // namespace vitrine
