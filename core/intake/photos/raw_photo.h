// Raw photos: which cameras they are of, their common white balance, their development to linear Rec. 709 (LibRaw,
// core/scene/image/camera_codecs.h).
//
// All photos of one camera are developed with the white balance of the first, without automatic brightness or white level, so
// that equal light gives equal colours in every photo.
#pragma once

#include <array>
#include <filesystem>
#include <span>
#include <string>

#include "core/intake/photos/exif.h"
#include "core/scene/image/camera_codecs.h"
#include "core/scene/image/image.h"

namespace vitrine {

using RawBalance = std::array<float, 4>;  // multipliers R, G, B, second G; all 0: that of the photo

struct RawHead {
  RawFacts facts;
  std::string problem;  // why the photo cannot be developed; empty if it can
};
RawHead raw_head(const std::filesystem::path& path);

// Whether a file with this lower-case extension (".cr2") is a raw photo by its name.
bool has_raw_extension(const std::string& extension);

// Size, orientation and exposure of LibRaw, where `exif` (of the file's own EXIF fields) has none.
void add_raw_facts(Exif& exif, const RawFacts& facts);

// Linear Rec. 709, as stored (not turned upright). `half`: at half of the size. Throws Error{Input} with the cause.
ImageF read_raw_photo(const std::filesystem::path& path, const RawBalance& balance, bool half);

// For each photo the balance of the first one of its camera; all 0 for those that are not raw or cannot be read.
std::vector<RawBalance> common_balance(std::span<const std::filesystem::path> photos);

}  // namespace vitrine
