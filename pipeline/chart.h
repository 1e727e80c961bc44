// Early checks of --grey-card and --scale-bar: format of the text, existence of the photos. The stage that uses them checks
// whether the positions lie inside the undistorted photos.
#pragma once

#include <string>

#include "core/foundation/base/file.h"

namespace vitrine {

// `text`: "photo:x,y,w,h". Throws Error{Usage, GREY_CARD}.
void check_grey_card(const std::string& text, const fs::path& photos);
// `text`: core/foundation/config/scale_bar.h. Throws Error{Usage, SCALE_BAR}.
void check_scale_bar(const std::string& text, const fs::path& photos);

}  // namespace vitrine
