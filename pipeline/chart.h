// The grey card and the scale bar in the picture, looked at before hours are spent on the way to the stage that needs them: the
// text must have its form and name photos that are there. Whether a box or a mark lies in the photo is known once the photos are
// undistorted: the stage says it.
#pragma once

#include <string>

#include "core/base/file.h"

namespace vitrine {

// `text`: "photo:x,y,w,h". Throws Error{Usage, GREY_CARD}.
void check_grey_card(const std::string& text, const fs::path& photos);
// `text`: core/config/scale_bar.h. Throws Error{Usage, SCALE_BAR}.
void check_scale_bar(const std::string& text, const fs::path& photos);

}  // namespace vitrine
