// export: the scene in other programs' formats (formats/registry.cpp). README.md in this folder lists them.
//   reads   sfm/{images,sparse/0,scene.json}, gaussians/diffuse.ply, mesh/mesh.ply
//   writes  export/<files of the chosen formats>, export/formats.json (which files, what they hold, what they lose)
// version 1: first.
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct ExportConfig {
  std::vector<std::string> formats{"ply-2dgs", "ply-3dgs", "colmap", "mesh-ply", "mesh-obj"};
};
void describe(Describer& d, ExportConfig& c);
std::string problem(const ExportConfig& config);  // empty, or which format is listed twice

void run_export(const ExportConfig& config, StageContext& context);
Stage export_stage();

}  // namespace vitrine
