// Entry points of the codec library, one source file each.
#pragma once

#include "core/scene/image/codecs.h"

namespace vitrine {

std::string decode_jpeg(std::string_view bytes, int channels, int reduction, Image8& out);
std::string decode_png(std::string_view bytes, Image8& out8, Image16& out16);
std::string decode_tiff(std::string_view bytes, const TiffRequest& request, const std::function<void(const TiffBlock&)>& put);

}  // namespace vitrine
