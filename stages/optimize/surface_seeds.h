// Points on the shapes of glass and mirrors (core/scene/objects), where surfels are put when their layer begins: neither has a texture
// that stays on it, and only its silhouette fixes its place.
#pragma once

#include <vector>

#include "core/scene/shape/shape_set.h"

namespace vitrine {

struct SurfaceSeed {
  Vec3f position, normal;  // outwards, unit
  bool known = false;      // to a fraction of a pixel (ShapeSet::Entry::exact); or on a visual hull, which wavers
  float apart = 1;         // distance to its neighbours, of the spacing
};
struct SurfaceSeeds {
  std::vector<SurfaceSeed> points;
  float spacing = 0;  // of most of them, scene units
};

// Evenly by area, 1/128 of the longest side of all shapes apart; appendages, which bend faster than what they stand
// out of, have six for one, without those inside their parent.
SurfaceSeeds surface_seeds(const ShapeSet& shapes);

}  // namespace vitrine
