// How long a scale bar is in scene units: both ends are triangulated from the photos in which they are marked.
//
// An end X is the point nearest to its rays c_i + t d_i, the midpoint of two rays:
//   sum_i (I - d_i d_i^T) X = sum_i (I - d_i d_i^T) c_i
// The bar does not stand still in the scene where the object was moved between passes of photos (passes.h): all marks must be of
// one pass.
#pragma once

#include <vector>

#include "core/scene/camera/passes.h"
#include "core/scene/camera/view.h"
#include "core/foundation/config/chart.h"

namespace vitrine {

struct ScaleBarLength {
  double scene_units = 0;
  double metres_per_unit = 0;
  double error_px = 0;   // rms distance between the marks and the projected ends
  double angle_rad = 0;  // the largest angle between two rays to an end, of the end where it is smaller
};

// Throws Error{Usage, SCALE_BAR}: a photo without camera, a mark outside of it, photos of two passes, rays that are almost
// parallel, marks that are not of one point.
ScaleBarLength scale_bar_length(const ScaleBar& bar, const std::vector<View>& views, const Passes& passes);

// "one unit of the scene is 0.213 m, by the scale bar, 0.4 px"
std::string scale_bar_text(const ScaleBarLength& length);

}  // namespace vitrine
