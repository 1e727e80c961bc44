// The grey card of a run, looked at before hours are spent on the way to the stage that needs it: the text must have its form and
// name one of the photos. Whether the box lies in the photo is known once the photos are undistorted: the decompose stage says
// it.
#pragma once

#include <string>

#include "core/base/file.h"

namespace vitrine {

// `text`: "photo:x,y,w,h". Throws Error{Usage, GREY_CARD}.
void check_grey_card(const std::string& text, const fs::path& photos);

}  // namespace vitrine
