// Sample points on the shapes of glass and mirrors (core/scene/objects), for the surfels that are placed when their layer begins.
// Both are textureless; only their silhouettes determine their position.
#pragma once

#include <vector>

#include "core/scene/shape/shape_set.h"

namespace vitrine {

struct SurfaceSeed {
  Vec3f position, normal;  // outwards, unit
  bool known = false;      // accurate to a fraction of a pixel (ShapeSet::Entry::exact); false on a visual hull
  float apart = 1;         // distance to its neighbours, relative to the spacing
};
struct SurfaceSeeds {
  std::vector<SurfaceSeed> points;
  float spacing = 0;  // typical distance of neighbours, scene units
};

// Samples uniformly by area, 1/128 of the longest side of all shapes apart. Appendages, which curve more than their parent, get
// six times as many; points inside the parent are dropped.
SurfaceSeeds surface_seeds(const ShapeSet& shapes);

}  // namespace vitrine
