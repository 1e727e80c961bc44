// Radiance HDR images (.hdr, .pic; Greg Ward): 8-bit RGB mantissas with a shared exponent, flat or run-length coded.
//   value = mantissa 2^(exponent - 136) / (EXPOSURE COLORCORR)
// EXPOSURE and COLORCORR are products over all header lines of that name, since every program that scales the image adds one.
// Rows and columns may be stored in any of eight orders. CIE XYZ is converted to RGB with Rec. 709 primaries and equal-energy
// white, the convention of Radiance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

// `name` is used in messages. `notes` receives one sentence per conversion. Throws Error{Input} (BAD_HDR) for damaged data.
ImageF parse_radiance_hdr(std::string_view bytes, const std::string& name, std::vector<std::string>* notes = nullptr);

}  // namespace vitrine
