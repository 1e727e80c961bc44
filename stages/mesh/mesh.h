// The mesh stage: triangle mesh from the rendered depth of the diffuse layer. TSDF fusion of all training views and marching
// cubes (mesh/mesh_raw.ply); removal of small components, repair, smoothing and decimation (mesh/mesh.ply); content behind glass
// (mesh/behind_glass.ply); on request the closed surface through the fused one (mesh/watertight.ply); mesh/report.json. README.md
// documents the options.
#pragma once

#include <span>
#include <vector>

#include "core/render/raster/renderer.h"
#include "core/scene/camera/view.h"
#include "core/scene/surfels/layers.h"
#include "stages/stage.h"

namespace vitrine {

// Bounding box of the meshed region. The cameras determine the kind of capture:
//   convergent   they face one place (object on a table): the box contains the sparse points nearer to that place than the
//                cameras, so distant walls do not cost resolution; with fewer than 20 such points, a cube that extends to the
//                cameras. Glass and mirrors have no sparse points because of their masks, so their trained surfels count too;
//                otherwise a glass case would be cut off above its foot
//   wide         they look along or outwards (street, room, flight): the box contains all sparse points except outliers

struct RegionDesc {
  double reach_rel = 1.0;   // convergent: points nearer to the focus than this times the median camera distance
  double margin = 0.1;      // added on each side, relative to the longest side
  std::vector<double> box;  // x0 y0 z0 x1 y1 z1 in the scene frame; overrides the rest
};

struct Region {
  Bounds3 box;
  bool convergent = false;
  Vec3d focus{};               // least-squares nearest point to the optical axes
  double camera_distance = 0;  // median, to the focus
  size_t points = 0;           // sparse points that determine the box; 0: it comes from the cameras or an option
  double extent() const;       // longest side
};

// Centres of the surfels of glass and mirrors: at least half opaque, and at least half transparent or specular.
std::vector<Vec3d> glass_and_gloss(const SplatLayer& diffuse);

// `unmarked`: additional points where there are no sparse points, from glass_and_gloss(); their outliers are removed separately.
// Throws Error{Input} with too few sparse points, and Error{Usage} for an invalid box.
Region scene_region(const ViewSet& set, const RegionDesc& desc, std::span<const Vec3d> unmarked = {});

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

enum class MeshMethod {
  Fusion,   // open where no photo looked
  Poisson,  // the closed surface through the fused one: mesh/mesh.ply
  Both      // fusion, and the closed surface as mesh/watertight.ply
};

struct MeshConfig {
  MeshMethod method = MeshMethod::Fusion;
  int resolution = 384;
  double voxel = 0;
  int faces = 200000;
  Backend backend = Backend::Cpu;
  RegionDesc region;
  MeshFusionConfig fusion;
  MeshCleanConfig clean;
};
void describe(Describer& d, MeshConfig& c);

void run_mesh(const MeshConfig& config, StageContext& context);
Stage mesh_stage();
StageCost mesh_cost(const CostTerms& terms);
StageReport mesh_report();

}  // namespace vitrine
