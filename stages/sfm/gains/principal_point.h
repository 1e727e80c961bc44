// Refinement of the principal points by a final bundle adjustment. COLMAP keeps the principal point at the image centre while it
// maps, because from few photos it is confused with the camera rotation. With all photos registered it is determined well; the
// result is accepted only if the reprojection error drops clearly. Real lenses are off by up to a few per cent of the picture;
// without the refinement the poses absorb this as a tilt, which is visible in reflections.
#pragma once

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

struct PrincipalPoints {
  bool asked = false;                        // enough photos and points, and only supported lens models
  bool moved = false;                        // the model contains the refined points
  double error_before = 0, error_after = 0;  // RMS reprojection error, pixels (robust)
  double furthest = 0;                       // largest offset from the image centre, relative to the longest side
};

// Single-threaded: same result on every machine of an instruction set. Also refines poses, points, focal lengths and distortion.
PrincipalPoints refine_principal_points(ColmapModel& model);

}  // namespace vitrine
