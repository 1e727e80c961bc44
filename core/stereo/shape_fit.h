// The simple shapes whose silhouettes the photos show: of one class of masks, or of one object.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/stereo/box_fit.h"
#include "core/stereo/revolution_fit.h"
#include "core/stereo/visual_hull.h"

namespace vitrine {

struct FittedShapes {
  std::optional<BoxFit> box;                // else:
  std::vector<SurfaceOfRevolution> solids;  // one for each connected piece of the hull that is one
};
FittedShapes fit_shapes(std::span<const Silhouette> silhouettes, const VisualHull& hull);

}  // namespace vitrine
