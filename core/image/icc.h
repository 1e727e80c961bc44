// ICC profiles (versions 2 and 4; matrices, grey curves, tables) through Little CMS; its headers stay in icc.cpp. Relative
// colorimetric, without black point compensation, in floating point without bounds.
#pragma once

#include <string>
#include <string_view>

#include "core/image/color_profile.h"

namespace vitrine {

struct IccProfile {
  ColorProfilePtr profile;  // nullptr: it cannot be used
  std::string problem;      // why not
  bool grey = false;        // of pictures of one channel
  bool cmyk = false;        // of print: there is no profile then
};

// Never throws for damaged bytes. One profile that many photos carry is read once.
IccProfile icc_profile(std::string_view bytes);

}  // namespace vitrine
