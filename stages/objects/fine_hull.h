// The visual hull of a part of an object to a fraction of a pixel. The grid of a whole hull is as coarse as the largest object in
// it, and a thin part is six of its cells wide, with normals to match; here a grid of its own, a field that is as soft as the
// masks' edges, and its level set.
#pragma once

#include <functional>

#include "core/foundation/math/rigid.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/observe/stereo/carving.h"
#include "core/observe/stereo/visual_hull.h"

namespace vitrine {

// Smoothed, with normals. `known`: what the whole hull says about a place that is not near its surface: 1 inside, 0 outside; -1
// near.
TriMesh fine_hull(const Carving& carving, const Bounds3& bounds, double cell, const std::function<int(const Vec3d&)>& known);

// The carved cells of a hull as a mesh, likewise smoothed; empty if the hull is.
TriMesh hull_mesh(const VisualHull& hull);

}  // namespace vitrine
