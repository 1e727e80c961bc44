#include "core/stereo/shape_fit.h"

#include "core/stereo/ball_fit.h"

namespace vitrine {

FittedShapes fit_shapes(std::span<const Silhouette> silhouettes, const VisualHull& hull) {
  FittedShapes out;
  if (hull.empty()) return out;
  out.box = fit_box(silhouettes, hull.bounds());
  if (!out.box) out.solids = surfaces_of_revolution(silhouettes, hull.surface(), hull.voxel());
  for (SurfaceOfRevolution& solid : out.solids)
    if (const auto ball = ball_of(silhouettes, solid)) solid = *ball;
  return out;
}

}  // namespace vitrine
