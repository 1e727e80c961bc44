// A scale bar of known length in the picture, as a user writes it: its two ends in two or more photos, and its length.
//
//   IMG_0007.jpg:120.5,410,388,402 IMG_0011.jpg:96,377,301.5,455 = 5cm
//
// photo:x1,y1,x2,y2 are pixels of the undistorted photo (images/<photo>), centres at .5; the ends have the same order in each
// photo.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

struct ScaleBarMark {
  std::string photo;
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
};

struct ScaleBar {
  std::vector<ScaleBarMark> marks;  // two or more, of different photos
  double length_m = 0;
};

// The names may hold spaces, commas and colons. Throws Error{Usage, SCALE_BAR}.
ScaleBar parse_scale_bar(const std::string& text);

}  // namespace vitrine
