// Development of one photo file to an upright linear image of at most max_side.
#pragma once

#include <filesystem>

#include "core/foundation/base/hash.h"
#include "core/intake/photos/photo_color.h"
#include "core/intake/photos/photo_list.h"
#include "core/intake/photos/raw_photo.h"
#include "core/scene/image/resample.h"

namespace vitrine::ingest {

struct Developed {
  Digest digest;                   // of the file
  ImageF linear;                   // upright, [h, w, 3]
  Photo photo;                     // all fields but name, stem and source
  RepairedValues repaired;         // of floating-point samples
  std::vector<std::string> notes;  // omitted or assumed content (core/scene/image/picture_file.h, core/scene/image/exr.h)
  std::string aside;
  ColorFacts color;
  bool panorama = false;  // of the whole sphere: not reduced to max_side, its views are
};

// `balance`: of PhotoFile. Throws Error{Input} when the file is empty, damaged or truncated.
Developed develop(const std::filesystem::path& path, int max_side, const RawBalance& balance = {});

// Peak memory of `develop` for a photo of `pixels` pixels, in bytes.
size_t develop_bytes(size_t pixels);

}  // namespace vitrine::ingest
