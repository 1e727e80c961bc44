// Decodes a photo file to linear Rec. 709, for all supported formats and colour profiles (core/intake/photos/photo_color.h).
#pragma once

#include <filesystem>

#include "core/intake/photos/photo_files.h"
#include "core/scene/image/image.h"
#include "core/scene/image/resample.h"

namespace vitrine {

struct LinearPhoto {
  ImageF linear;            // [h, w, 3], as stored (not turned upright); may be negative for colours outside Rec. 709
  ImageF alpha;             // [h, w, 1]; empty when missing or constant
  RepairedValues repaired;  // of floating-point samples
};

// Throws Error{Input} when the file is damaged. `head`: of the same file.
LinearPhoto read_linear_photo(const std::filesystem::path& path, const PhotoHead& head);

// Converts an 8-bit decoded photo, of any size, from the colour space of the file to sRGB. An sRGB photo is returned unchanged.
Image8 srgb_of(const Image8& decoded, const PhotoColor& color);

// Whether the file has an alpha channel that is not constant; decodes the picture if the file declares one.
bool has_varying_alpha(const std::filesystem::path& path, const PhotoHead& head);

// Preview of a photo: 8-bit sRGB, decoded at reduced size, as stored (not turned upright). The longest side has at least `side`
// pixels where the photo has so many, and less than twice as many. Throws Error{Input} when the file is damaged. `head`: of the
// same file.
Image8 reduced_photo(const std::filesystem::path& path, const PhotoHead& head, int side);

// Upright, the longest side at most `side`; smaller photos keep their size.
Image8 upright_photo(const std::filesystem::path& path, const PhotoHead& head, int side);

struct PhotoSize {
  int width = 0, height = 0;
};
// Upright, before any reduction; 0 when the head does not contain it.
PhotoSize upright_size(const PhotoHead& head);

}  // namespace vitrine
