// TIFF reader: contiguous and planar, strips and tiles, 1 to 16 and 32 bits, half, float and double, grey, RGB, palettes and
// YCbCr, all libtiff compressions, classic and BigTIFF. tiff_pages.h reports unsupported files.
#pragma once

#include <string>
#include <string_view>
#include <variant>

#include "core/scene/image/image.h"
#include "core/scene/image/tiff_pages.h"

namespace vitrine {

// Grey (1 channel) or RGB (3), with alpha 4 channels; up to 8 bits as 8, up to 16 and 32 bits as 16, floating point as float.
// Premultiplied colours are divided by alpha. The orientation of the page is not applied.
using AnyImage = std::variant<Image8, Image16, ImageF>;

// Returns an error message, empty on success. `pages` are those of `bytes`, and tiff_refusal(pages) is empty.
std::string read_tiff(std::string_view bytes, const TiffPages& pages, AnyImage& out);

}  // namespace vitrine
