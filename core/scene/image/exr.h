// OpenEXR files with named channels and provenance attributes. Whole-file semantics: written beside the target and renamed.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

enum class ExrPrecision { Half, Float };

struct ExrImage {
  ImageF pixels;                                  // [h, w, names.size()]
  std::vector<std::string> channels;              // e.g. {"R","G","B"}, {"X","Y","Z"}, {"Z"}, {"normal.x", ...}
  std::map<std::string, std::string> attributes;  // string attributes, e.g. "vitrine:stage"
};

inline constexpr size_t kMaxExrPixels = size_t(1) << 28;

// All channels of the part that holds the picture (core/scene/image/exr_layers.h; else of the first one), in the display window: pixels
// that the file does not store are 0, those outside of it are left out. Channels come back in the order R,G,B,A / X,Y,Z when they
// carry those names (whatever the file's order), else by name. Throws Error{Input} that names the file when it is missing,
// truncated, not EXR, or larger than `max_pixels`.
ExrImage read_exr(const std::filesystem::path& path, size_t max_pixels = kMaxExrPixels);

struct ExrPicture {
  ImageF rgb;                      // grey is repeated
  ImageF alpha;                    // one channel; empty when the layer has none or it is not asked for
  std::vector<std::string> notes;  // what was chosen, cropped or filled: "an EXR of several layers: ..."
};
// The colours of the layer that is the picture: Combined, beauty, rgba, R, G, B without a prefix, or the only layer that has any;
// also of multi-part, stereo, tiled and luminance-chroma files. Throws with the names of the channels when there is none.
ExrPicture read_exr_picture(const std::filesystem::path& path, bool with_alpha = false);
// The same refusals and notes without reading pixels.
std::vector<std::string> exr_notes(const std::filesystem::path& path);
ImageF read_exr_rgb(const std::filesystem::path& path);
void write_exr(const std::filesystem::path& path, const ExrImage& image, ExrPrecision precision = ExrPrecision::Half);
void write_exr_rgb(const std::filesystem::path& path, const ImageF& rgb, ExrPrecision precision = ExrPrecision::Half,
                   const std::map<std::string, std::string>& attributes = {});

}  // namespace vitrine
