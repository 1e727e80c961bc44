// The flat faces of a thing known by its silhouette alone. A visual hull is right where photos look along a surface and bulges
// between; it is also made of voxels. The panes of a case, a window or a bottle with sides are flat: the plane through all of a
// face's points is nearer to the pane than they are (a case of five panes, true masks: normals 18.5 degrees off, then 7.3).
#pragma once

#include <span>
#include <vector>

#include "core/math/rigid.h"
#include "core/shape/hit.h"

namespace vitrine {

struct FlatFace {
  Vec3d normal;       // outwards, unit
  double offset = 0;  // normal.X = offset
  Bounds3 bounds;     // of the surface on it: other things stand in the same plane
};

// Largest first. Empty unless at least two thirds of the surface lie on faces of a fourteenth of it or more each: a ball, a
// bottle, a vase has none. `voxel`: of the grid that the surface was found on.
std::vector<FlatFace> flat_faces(std::span<const ShapePoint> surface, double voxel);

// The face that a point of the surface belongs to: of those whose surface is not further than five voxels, and that are turned by
// 45 degrees at most, the one that is turned least; null = none.
const FlatFace* face_of(std::span<const FlatFace> faces, const ShapePoint& point, double voxel);

}  // namespace vitrine
