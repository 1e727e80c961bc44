// User-given measures in photos: a box, a length, a scale bar.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vitrine {

// "photo:x,y,w,h": left, top, width and height in pixels.
struct PhotoBox {
  std::string photo;
  int x = 0, y = 0, width = 0, height = 0;
};

// nullopt for invalid syntax, an empty box or negative coordinates. The name may contain colons.
std::optional<PhotoBox> parse_photo_box(std::string_view text);

// "24cm", "0.24 m", "240mm".
struct Length {
  double metres = 0;
  bool has_unit = false;  // without a unit: metres
};

// nullopt for invalid syntax, or a length that is not finite and positive.
std::optional<Length> parse_length(std::string_view text);

// Scale bar of known length in user syntax: its two ends in two or more photos, and its length.
//
//   IMG_0007.jpg:120.5,410,388,402 IMG_0011.jpg:96,377,301.5,455 = 5cm
//
// photo:x1,y1,x2,y2 are pixels of the undistorted photo (images/<photo>), centres at .5; the ends have the same order in each
// photo.
struct ScaleBarMark {
  std::string photo;
  double x1 = 0, y1 = 0, x2 = 0, y2 = 0;
};

struct ScaleBar {
  std::vector<ScaleBarMark> marks;  // at least two, of different photos
  double length_m = 0;
};

// Names may contain spaces, commas and colons. Throws Error{Usage, SCALE_BAR}.
ScaleBar parse_scale_bar(const std::string& text);

// Two points of the scene, in its own frame and unit, and the length between them: "0.12,-0.4,0.3 0.5,0.1,0.3 24cm", as the page
// of `vitrine view` writes it.
struct ScalePoints {
  std::array<double, 3> a{}, b{};
  double length_m = 0;

  double scene_units() const;  // positive
};

// Throws Error{Usage, SCALE_POINTS}: wrong syntax, a coordinate that is not finite, equal points, a length without a unit.
ScalePoints parse_scale_points(const std::string& text);

}  // namespace vitrine
