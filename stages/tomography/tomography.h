// tomography: X-ray projections of an object, as a volume of voxels. Started by `vitrine ct`; not part of the graph of
// `vitrine run`.
//   reads   scan: a YAML file (README.md) that names the projections (scan_pictures: these enter the key)
//   writes  ct/volume.nrrd, ct/slices/*.exr, ct/surface.ply, ct/*.png, ct/report.json
#pragma once

#include "core/scene/mesh/tri_mesh.h"
#include "stages/stage.h"
#include "stages/tomography/scan_geometry.h"

namespace vitrine {

struct TomographyConfig {
  int voxels = 0;
  int rounds = 5;
  double tv = 0.015;
  double iso = 0;
};
void describe(Describer& d, TomographyConfig& c);

void run_tomography(const TomographyConfig& config, StageContext& context);
Stage tomography_stage();

// --- outputs.cpp -----------------------------------------------------------------------------------------------------------

// Threshold between the two classes of values that differ most (Otsu 1979), over 256 steps up to the 99.9th percentile.
double otsu_threshold(const VoxelGrid<float>& volume);
// Where the density is `iso`, closed at the border of the grid; normals point to lower density. Empty if nothing is denser.
TriMesh density_surface(const VoxelGrid<float>& volume, double iso);
// NRRD 4: a text header and little-endian floats, x fastest. `unit` of the grid's lengths.
void write_nrrd(const std::filesystem::path& path, const VoxelGrid<float>& volume, const std::string& unit);
// One EXR a layer of z, from below, rows with +y up; and three PNG through the middle.
void write_slices(const std::filesystem::path& folder, const VoxelGrid<float>& volume, const std::string& unit);

}  // namespace vitrine
