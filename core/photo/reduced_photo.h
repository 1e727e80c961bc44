// A photo for looking at: 8-bit sRGB, decoded small, whatever its format and its colours.
#pragma once

#include <filesystem>

#include "core/image/image.h"
#include "core/photo/photo_files.h"

namespace vitrine {

// As stored (not turned upright). The longest side has at least `side` pixels where the photo has so many, and less than twice as
// many. Throws Error{Input} when the file is damaged. `head` is that of the file.
Image8 reduced_photo(const std::filesystem::path& path, const PhotoHead& head, int side);

// Upright, the longest side at most `side`; smaller photos keep their size.
Image8 upright_photo(const std::filesystem::path& path, const PhotoHead& head, int side);

struct PhotoSize {
  int width = 0, height = 0;
};
// Upright, as photographed; 0 when the head does not say it.
PhotoSize upright_size(const PhotoHead& head);

}  // namespace vitrine
