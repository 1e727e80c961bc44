// Objects of glass and of polished metal: the masks of a class, divided into those of connected pieces of their visual hull.
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

// `silhouettes`: of all objects of the class. None when no closed region agrees with them, those of a window for example. Pieces
// smaller than a fiftieth of the largest one are no objects: cones of few photos also meet where nothing is.
std::vector<MaskedObject> masked_objects(MaskClass kind, const std::vector<Silhouette>& silhouettes, const HullDesc& desc);

}  // namespace vitrine
