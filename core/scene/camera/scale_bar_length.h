// Measures in photos that have cameras. The box of a grey card; the length of a scale bar in scene units: both ends are
// triangulated from the photos in which they are marked.
//
// An end X is the point nearest to its rays c_i + t d_i (the midpoint, for two rays):
//   sum_i (I - d_i d_i^T) X = sum_i (I - d_i d_i^T) c_i
// If the object was moved between passes of photos (scene_info.h), the bar is not static in the scene: all marks must be of one
// pass.
#pragma once

#include <vector>

#include "core/foundation/config/chart.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view.h"

namespace vitrine {

// Box of a grey card, in pixels of the undistorted photo.
struct CardBox {
  size_t view = 0;
  int x = 0, y = 0, width = 0, height = 0;
};

// Throws Error{Usage, GREY_CARD} for another format than "photo:x,y,w,h", a photo without camera or a box outside the photo.
CardBox card_box(const std::string& text, const std::vector<View>& views);

struct ScaleBarLength {
  double scene_units = 0;
  double metres_per_unit = 0;
  double error_px = 0;   // rms distance between the marks and the projected ends
  double angle_rad = 0;  // largest angle between two rays to an end; minimum of both ends
};

// Throws Error{Usage, SCALE_BAR}: photo without camera, mark outside the photo, photos of two passes, nearly parallel rays,
// marks that are not of one point.
ScaleBarLength scale_bar_length(const ScaleBar& bar, const std::vector<View>& views, const Passes& passes);

// "one unit of the scene is 0.213 m, by the scale bar, 0.4 px"
std::string scale_bar_text(const ScaleBarLength& length);

}  // namespace vitrine
