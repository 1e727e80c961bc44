// Fits a box or surfaces of revolution to the silhouettes of one mask class or one object.
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
  std::vector<SurfaceOfRevolution> solids;  // one for each connected component of the visual hull that is one
};
FittedShapes fit_shapes(std::span<const Silhouette> silhouettes, const VisualHull& hull);

// Fits a sphere to a surface of revolution. Photos from one height see no contour of the top and the foot of a ball, occluders
// hide parts of it, and a free profile ends in cones there; the four parameters of a sphere follow from any part of it. Returns
// the sphere through the flank of `surface`, centred on its axis, where it matches most photos as well as `surface`; else
// nullopt.
std::optional<SurfaceOfRevolution> ball_of(std::span<const Silhouette> silhouettes, const SurfaceOfRevolution& surface);

}  // namespace vitrine
