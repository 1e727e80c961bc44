// One photo file -> an upright linear image of at most max_side.
#pragma once

#include <filesystem>

#include "core/camera/photo_list.h"
#include "core/image/image.h"
#include "core/photo/photo_color.h"

namespace vitrine::ingest {

struct Developed {
  ImageF linear;  // upright, [h, w, 3]
  Photo photo;    // all but name, stem and source
  ColorFacts color;
  size_t repaired_pixels = 0;  // floating-point samples: not finite, set to 0
};

// Throws Error{Input} when the file is empty, damaged or truncated.
Developed develop(const std::filesystem::path& path, int max_side);

// Bytes that `develop` needs at its peak for a photo of so many pixels.
size_t develop_bytes(size_t pixels);

}  // namespace vitrine::ingest
