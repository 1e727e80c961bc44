// The mesh stage: triangle mesh from the rendered depth of the diffuse layer. TSDF fusion of all training views and marching
// cubes (mesh/mesh_raw.ply); removal of small components, repair, smoothing and decimation (mesh/mesh.ply); content behind glass
// (mesh/behind_glass.ply); mesh/report.json. README.md documents the options.
#pragma once

#include "core/render/raster/renderer.h"
#include "stages/mesh/region.h"
#include "stages/stage.h"

namespace vitrine {

struct MeshFusionConfig {
  double free_space_weight = 0.2;
  int memory_mb = 1024;
};
void describe(Describer& d, MeshFusionConfig& c);

struct MeshCleanConfig {
  double min_component = 0.005;
  int keep_components = 0;
  int smooth_iterations = 5;
  int fill_holes = 64;
};
void describe(Describer& d, MeshCleanConfig& c);
void describe(Describer& d, RegionDesc& c);

struct MeshConfig {
  int resolution = 384;
  double voxel = 0;
  int faces = 200000;
  Backend backend = Backend::Cpu;
  RegionDesc region;
  MeshFusionConfig fusion;
  MeshCleanConfig clean;
};
void describe(Describer& d, MeshConfig& c);

Stage mesh_stage();
StageCost mesh_cost(const CostTerms& terms);
StageReport mesh_report();

}  // namespace vitrine
