// Zero level set of a TSDF as a triangle mesh: marching cubes with face-consistent cases (cell_cases.h). Vertices are shared
// per grid edge: the surface is manifold, and closed except at unobserved voxels.
#pragma once

#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/mesh/tsdf_volume.h"

namespace vitrine {

struct IsoDesc {
  float min_weight = 1e-6f;  // cells with a corner below this weight produce no surface
  // Maximum difference of normalised distance between neighbours at a crossing. Larger jumps are the border of the observed
  // space, not a surface: in a truncation band of 4 voxels neighbours differ by about 1/4. 2 or more = off.
  float max_jump = 2.f;
};

// Normals = gradient of the field (towards free space), colours linear. The mesh does not depend on the number of threads.
TriMesh iso_surface(const TsdfVolume& volume, const IsoDesc& desc = {});

}  // namespace vitrine
