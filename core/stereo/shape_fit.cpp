#include "core/stereo/shape_fit.h"

namespace vitrine {

FittedShapes fit_shapes(std::span<const Silhouette> silhouettes, const VisualHull& hull) {
  FittedShapes out;
  if (hull.empty()) return out;
  out.box = fit_box(silhouettes, hull.bounds());
  if (!out.box) out.solids = surfaces_of_revolution(silhouettes, hull.surface(), hull.voxel());
  return out;
}

}  // namespace vitrine
