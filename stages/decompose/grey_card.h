// A card of known albedo in one photo: "photo:x,y,w,h", pixels of the undistorted photo (images/<photo>).
#pragma once

#include <string>
#include <vector>

#include "core/camera/view.h"
#include "core/image/image.h"

namespace vitrine {

struct GreyCard {
  size_t view = 0;
  int x = 0, y = 0, width = 0, height = 0;
};

// Throws Error{Usage} when the text is not of that form, names no photo or a box outside of it.
GreyCard parse_grey_card(const std::string& text, const std::vector<View>& views);
// Median over the box of a picture of the view at any size. Throws Error{Input} when nothing is there.
Vec3f median_in(const GreyCard& card, const View& view, const ImageF& picture);

}  // namespace vitrine
