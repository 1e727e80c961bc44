// Visual hull of a part of an object at subpixel precision. The grid of the whole hull is as coarse as the largest object
// requires: a thin part is six cells wide, with coarse normals. Here the part has a grid of its own, an occupancy field as soft
// as the edges of the masks, and its level set.
#pragma once

#include <functional>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/observe/stereo/carving.h"
#include "core/observe/stereo/visual_hull.h"

namespace vitrine {

// Smoothed, with normals. `known`: result of the whole hull away from its surface: 1 inside, 0 outside; -1 near the surface.
TriMesh fine_hull(const Carving& carving, const Bounds3& bounds, double cell, const std::function<int(const Vec3d&)>& known);

// Mesh of the carved cells of a hull, smoothed in the same way; empty for an empty hull.
TriMesh hull_mesh(const VisualHull& hull);

}  // namespace vitrine
