// An 8-bit picture of 1 or 3 channels as the bytes of a JPEG file, for documents that carry pictures inside (report.html).
#pragma once

#include <string>

#include "core/image/image.h"

namespace vitrine {

std::string jpeg_bytes(const Image8& image, int quality);

}  // namespace vitrine
