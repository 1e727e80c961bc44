// OpenEXR files with named channels and provenance attributes. Written atomically: to a temporary file, then renamed.
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

// All channels of the main part (core/scene/image/exr_layers.h; else of the first part) in the display window: missing pixels
// are 0, pixels outside are dropped. Channel order R,G,B,A / X,Y,Z if they have those names, else by name. Throws Error{Input}
// with the file name if it is missing, truncated, not EXR, or larger than `max_pixels`.
ExrImage read_exr(const std::filesystem::path& path, size_t max_pixels = kMaxExrPixels);

struct ExrPicture {
  ImageF rgb;                      // grey is replicated
  ImageF alpha;                    // one channel; empty if the layer has none or it was not requested
  std::vector<std::string> notes;  // what was selected, cropped or filled: "an EXR of several layers: ..."
};
// Colours of the main layer: Combined, beauty, rgba, R, G, B without prefix, or the only layer that has them. Supports
// multi-part, stereo, tiled and luminance-chroma files. Throws with the channel names if there is none.
ExrPicture read_exr_picture(const std::filesystem::path& path, bool with_alpha = false);
// Same errors and notes, without reading pixels.
std::vector<std::string> exr_notes(const std::filesystem::path& path);
ImageF read_exr_rgb(const std::filesystem::path& path);
void write_exr(const std::filesystem::path& path, const ExrImage& image, ExrPrecision precision = ExrPrecision::Half);
void write_exr_rgb(const std::filesystem::path& path, const ImageF& rgb, ExrPrecision precision = ExrPrecision::Half,
                   const std::map<std::string, std::string>& attributes = {});

}  // namespace vitrine
