// The normals of disks, turned to the side from which the photos see them. A disk has two sides and training tells them not
// apart; programs that light surfels want the outer one.
#pragma once

#include <vector>

#include "core/mesh/tri_mesh.h"
#include "core/scene/layers.h"

namespace vitrine {

// [surfels] unit. The outer side is that of the nearest vertex of the mesh within `reach`. Where the mesh is not, it is the side
// of the camera ring, which has the radius 1 about the origin: inwards outside of it, outwards inside.
std::vector<Vec3f> outward_normals(const SplatLayer& layer, const TriMesh& mesh, float reach);

}  // namespace vitrine
