// The simple shapes whose silhouettes the photos show: of one class of masks, or of one object.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/shape/surface_of_revolution.h"
#include "core/observe/stereo/box_fit.h"
#include "core/observe/stereo/revolution_fit.h"
#include "core/observe/stereo/silhouette.h"
#include "core/observe/stereo/visual_hull.h"

namespace vitrine {

struct FittedShapes {
  std::optional<BoxFit> box;                // else:
  std::vector<SurfaceOfRevolution> solids;  // one for each connected piece of the hull that is one
};
FittedShapes fit_shapes(std::span<const Silhouette> silhouettes, const VisualHull& hull);

// A ball among the surfaces of revolution. Photos from one height see no silhouette of its top and its foot, things in front hide
// parts of it, and a profile that is free ends in cones there. A sphere has four numbers, which any part of it fixes.
// The sphere through the flank of `surface`, about its axis, where most photos show it as well as `surface` itself; else nullopt.
std::optional<SurfaceOfRevolution> ball_of(std::span<const Silhouette> silhouettes, const SurfaceOfRevolution& surface);

}  // namespace vitrine
