// Separation of glass and specular objects: splits the masks of a class by the connected components of their visual hull.
#pragma once

#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/observe/stereo/visual_hull.h"

namespace vitrine {

struct MaskedObject {
  MaskClass kind = MaskClass::Transparent;
  std::vector<Silhouette> silhouettes;  // pixels of other objects of the class are unknown
  VisualHull hull;                      // not empty
};

// `silhouettes`: of all objects of the class. Empty if no closed region is consistent with them, e.g. for a window. Components
// smaller than a fiftieth of the largest are dropped: the cones of a few photos also intersect in empty space.
std::vector<MaskedObject> masked_objects(MaskClass kind, const std::vector<Silhouette>& silhouettes, const HullDesc& desc);

}  // namespace vitrine
