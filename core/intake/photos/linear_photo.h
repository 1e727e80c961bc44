// A photo file as light: linear Rec. 709, whatever its format and its colours (core/intake/photos/photo_color.h).
#pragma once

#include <filesystem>

#include "core/scene/image/image.h"
#include "core/scene/image/repair.h"
#include "core/intake/photos/photo_files.h"

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

// A photo for looking at: 8-bit sRGB, decoded small. As stored (not turned upright). The longest side has at least `side` pixels
// where the photo has so many, and less than twice as many. Throws Error{Input} when the file is damaged. `head` is that of the
// file.
Image8 reduced_photo(const std::filesystem::path& path, const PhotoHead& head, int side);

// Upright, the longest side at most `side`; smaller photos keep their size.
Image8 upright_photo(const std::filesystem::path& path, const PhotoHead& head, int side);

struct PhotoSize {
  int width = 0, height = 0;
};
// Upright, as photographed; 0 when the head does not say it.
PhotoSize upright_size(const PhotoHead& head);

}  // namespace vitrine
