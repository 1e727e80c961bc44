// Pictures of Greg Ward's Radiance (.hdr, .pic): an RGB mantissa of 8 bits each and a shared exponent, flat or run-length coded.
//   value = mantissa 2^(exponent - 136) / (EXPOSURE COLORCORR)
// where EXPOSURE and COLORCORR are the products of all lines of the header that say so, since every program that scales the
// picture adds one. Rows and columns may be stored in any of the eight orders. CIE XYZ becomes RGB of Rec. 709's primaries with
// the white of equal energy, the convention of Radiance.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/image/image.h"

namespace vitrine {

// `name` is for messages. `notes`: what was converted, one sentence each. Throws Error{Input} (BAD_HDR) when the bytes are
// damaged.
ImageF parse_radiance_hdr(std::string_view bytes, const std::string& name, std::vector<std::string>* notes = nullptr);

}  // namespace vitrine
