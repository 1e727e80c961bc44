// The evaluate stage: quality metrics of the scene. It compares held-out views with their photos per region, and, with a truth
// folder, poses, normals, depth and mesh with the ground truth. README.md in this folder defines every figure.
//   reads   sfm/{sparse,linear,gains}, gaussians/*.ply, optimize/{views,model}.json; optional mesh/mesh.ply, masks, decompose
//           and the truth folder
//   writes  eval/metrics.json, eval/per_view.csv, eval/contact_sheet.jpg, eval/<stem>_{gt,pred,err,conf}.png,
//           eval/layers/<layer>/<stem>.exr, eval/relit/<environment>/<stem>.png
#pragma once

#include "core/render/raster/renderer.h"
#include "stages/stage.h"

namespace vitrine {

struct EvaluateConfig {
  Backend backend = Backend::Cpu;
  bool score_train_views = true;
  bool write_pictures = true;
  bool write_layers = true;
  int samples = 0;
  int relit_samples = 32;
  int relit_views = 4;
  double mesh_threshold_rel = 0.01;
  std::string lpips;
  // Not options; tests set them.
  int min_region_pixels = 64;  // minimum pixels of a region in a counted view
  int mesh_samples = 100'000;  // points sampled per mesh
  int mesh_views = 64;         // views used for visibility
};
void describe(Describer& d, EvaluateConfig& c);

void run_evaluate(const EvaluateConfig& config, StageContext& context);
Stage evaluate_stage();
StageCost evaluate_cost(const CostTerms& terms);
StageReport evaluate_report();

}  // namespace vitrine
