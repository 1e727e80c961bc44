// The surface of one thing in the hull, to a fraction of a pixel. The grid of the whole hull is as coarse as the largest thing in
// it, and a thin part is six of its cells wide, with normals to match; here a grid of its own, a field that is as
// soft as the masks' edges are, and its gradient.
#pragma once

#include <functional>
#include <vector>

#include "core/math/rigid.h"
#include "core/mesh/tri_mesh.h"
#include "core/stereo/flat_faces.h"
#include "stages/optimize/hull_judges.h"

namespace vitrine {

struct FineHull {
  std::vector<HullSurfacePoint> points;  // one for every cell that the surface passes, on the surface, with its normal
  TriMesh mesh;                          // the same, smoothed
};
// `known`: what the whole hull says about a place that is not near its surface, and need not be asked again: 1 inside, 0 outside;
// -1 near.
FineHull fine_hull(const std::vector<HullJudge>& judges, const Bounds3& bounds, double cell,
                   const std::function<int(const Vec3d&)>& known);

}  // namespace vitrine
