// An 8-bit picture of 1 or 3 channels as the bytes of a PNG file, for formats that carry pictures inside (GLB).
#pragma once

#include <string>

#include "core/image/image.h"

namespace vitrine {

std::string png_bytes(const Image8& image);

}  // namespace vitrine
