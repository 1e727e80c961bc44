// The export stage: the scene in the formats of other programs (formats/registry.cpp). README.md in this folder lists them.
//   reads   sfm/{images,sparse/0,scene.json,sfm/passes.json}, gaussians/*.ply, mesh/mesh.ply, decompose/materials.ply (optional)
//   writes  export/<files of the chosen formats>, export/formats.json (files, their contents and losses)
#pragma once

#include "stages/export/formats/source.h"
#include "stages/stage.h"

namespace vitrine {

struct ExportConfig {
  std::vector<std::string> formats = export_format_names();
  ExportAxes axes = ExportAxes::Rhzu;
  double scale = 0;
  std::string scale_bar = {};
  std::string scale_points = {};
  int texture_size = 0;
};
void describe(Describer& d, ExportConfig& c);
std::string problem(const ExportConfig& config);  // empty, or the error: a duplicate format or mutually exclusive options

void run_export(const ExportConfig& config, StageContext& context);
Stage export_stage();
StageCost export_cost(const CostTerms& terms);
// Contents and losses of each format, as text of at most 100 columns.
std::string format_table();

}  // namespace vitrine
