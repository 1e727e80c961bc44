// Pictures of Greg Ward's Radiance (.hdr, .pic): an RGB mantissa of 8 bits each and a shared exponent, flat or run-length coded.
//   value = mantissa 2^(exponent - 136)
#pragma once

#include <string_view>

#include "core/image/image.h"

namespace vitrine {

// `name` is for messages. Throws Error{Input} (BAD_HDR) when the bytes are damaged, or hold XYZ or a mirrored or turned picture.
ImageF parse_radiance_hdr(std::string_view bytes, const std::string& name);

}  // namespace vitrine
