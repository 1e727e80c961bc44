// The zero level of a TSDF as triangles: marching cubes with face-consistent cases (cell_cases.h), vertices shared by grid
// edge, so the surface is manifold and closed except where it meets voxels that nobody saw.
#pragma once

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/mesh/tsdf_volume.h"

namespace vitrine {

struct IsoDesc {
  float min_weight = 1e-6f;  // a cell with a corner below this weight gives no surface
  // A crossing between neighbours whose normalised distances differ by more is the end of what was seen, not a surface:
  // within a truncation band of 4 voxels honest neighbours differ by about 1/4. 2 and more = off.
  float max_jump = 2.f;
};

// Normals = gradient of the field (towards the free side), colours linear. Same mesh for any number of threads.
TriMesh iso_surface(const TsdfVolume& volume, const IsoDesc& desc = {});

}  // namespace vitrine
