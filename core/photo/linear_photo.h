// A photo file as light: linear Rec. 709, whatever its format and its colours (core/photo/photo_color.h).
#pragma once

#include <filesystem>

#include "core/image/image.h"
#include "core/image/repair.h"
#include "core/photo/photo_files.h"

namespace vitrine {

struct LinearPhoto {
  ImageF linear;            // [h, w, 3], as stored (not turned upright); may be negative where a colour lies outside of Rec. 709
  ImageF alpha;             // [h, w, 1]; empty when there is none, or the same everywhere
  RepairedValues repaired;  // of floating-point samples
};

// Throws Error{Input} when the file is damaged. `head` is that of the file.
LinearPhoto read_linear_photo(const std::filesystem::path& path, const PhotoHead& head);

// An 8-bit decoding of the photo, of any size, in the colours of the file -> in sRGB. A photo that is sRGB stays as it is.
Image8 srgb_of(const Image8& decoded, const PhotoColor& color);

// Whether there is an alpha channel that is not the same everywhere: decodes the picture when the file says that it has one.
bool has_varying_alpha(const std::filesystem::path& path, const PhotoHead& head);

}  // namespace vitrine
