// z-depth of a triangle mesh in one view, by scan conversion: what is the first surface at a pixel, and is a point hidden?
// One sample per pixel centre; 1/z is linear on the screen; triangles are clipped at the near plane.
#pragma once

#include "core/camera/projection.h"
#include "core/image/image.h"
#include "core/mesh/tri_mesh.h"

namespace vitrine {

// One channel, camera z; 0 where no triangle is.
ImageF mesh_zdepth(const TriMesh& mesh, const Intrinsics& intrinsics, const Rigid& cam_from_world);

// Whether a surface at camera depth p.z can be the one that `zdepth` shows around p: one of the four nearest samples agrees
// to `tolerance_rel` of its depth.
bool agrees_with(const ImageF& zdepth, const ImagePoint& p, double tolerance_rel);

}  // namespace vitrine
