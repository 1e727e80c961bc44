// COLMAP keeps the principal point in the middle of the photos, and rightly so while it maps: from few photos it is confused with
// where the camera looks. Once all are placed they tell it: a last bundle adjustment with it free, which counts where the photos
// then fit clearly better. Lenses are off by up to a few per cent of the picture; poses learn to lean by as much, and mirrored
// pictures show it.
#pragma once

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

struct PrincipalPoints {
  bool asked = false;                        // enough photos and points, and lens models that are known here
  bool moved = false;                        // the model has them
  double error_before = 0, error_after = 0;  // root mean square of the reprojection errors, pixels (large ones count less)
  double furthest = 0;                       // from the middle, of the longest side
};

// One thread, the same numbers on every machine of an instruction set. Poses, points, focal lengths and distortion move along.
PrincipalPoints refine_principal_points(ColmapModel& model);

}  // namespace vitrine
