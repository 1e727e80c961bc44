// What an EXR says of its colours: linear values of the primaries in its attribute "chromaticities", of Rec. 709 without one.
#pragma once

#include <string>
#include <string_view>

#include "core/image/color_profile.h"

namespace vitrine {

struct ExrPrimaries {
  ColorProfilePtr profile = linear_rec709_profile();
  bool stated = false;  // by the file
  std::string problem;  // why what it states is not used
};

// `bytes`: the file, or as much of its beginning as holds the header.
ExrPrimaries exr_primaries(std::string_view bytes);

}  // namespace vitrine
