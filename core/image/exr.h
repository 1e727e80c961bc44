// OpenEXR files with named channels and provenance attributes. Whole-file semantics: written beside the target and renamed.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/image/image.h"

namespace vitrine {

enum class ExrPrecision { Half, Float };

struct ExrImage {
  ImageF pixels;                                     // [h, w, names.size()]
  std::vector<std::string> channels;                 // e.g. {"R","G","B"}, {"X","Y","Z"}, {"Z"}, {"normal.x", ...}
  std::map<std::string, std::string> attributes;     // string attributes, e.g. "vitrine:stage"
};

// Channels come back in the order R,G,B,A / X,Y,Z when they carry those names (whatever the file's order), else by name.
// Throws Error{Input} that names the file when it is missing, truncated, not EXR, or larger than `max_pixels`.
ExrImage read_exr(const std::filesystem::path& path, size_t max_pixels = size_t(1) << 28);
// Three channels R,G,B of a file (grey is repeated); throws when the file has none of R, Y.
ImageF read_exr_rgb(const std::filesystem::path& path);
void write_exr(const std::filesystem::path& path, const ExrImage& image, ExrPrecision precision = ExrPrecision::Half);
void write_exr_rgb(const std::filesystem::path& path, const ImageF& rgb, ExrPrecision precision = ExrPrecision::Half,
                   const std::map<std::string, std::string>& attributes = {});

}  // namespace vitrine
