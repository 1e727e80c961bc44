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

// All channels of the main part (core/scene/image/exr.h; else of the first part) in the display window: missing pixels
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

// Channel selection for OpenEXR files. Renderers write many layers: by prefix ("ViewLayer.Combined.R", "diffuse.R"), by part
// name, and by stereo view. The selection uses names only and needs no pixels.
struct ExrPart {
  std::string name, view;             // attributes of the part; often empty
  bool deep = false;                  // several samples per pixel
  std::vector<std::string> channels;  // in file order
};

struct ExrColors {
  size_t part = 0;
  std::vector<std::string> channels;  // R, G, B; or one grey channel; or Y, RY, BY; empty if `refusal` is set
  std::string alpha;                  // alpha channel of the same layer; empty if none
  bool luminance_chroma = false;      // Y, RY, BY
  std::string refusal;                // reason why no colours were found, with the channel names
  std::vector<std::string> notes;     // choices made
};

// Order of preference: a layer (or part) named combined (composite.combined first), beauty, rgba; channels without prefix; the
// only layer with R, G, B. Then grey channels in the same order. For stereo the first view (`views`: attribute multiView).
ExrColors exr_colors(const std::vector<ExrPart>& parts, const std::vector<std::string>& views);

// "R", "G", "B" for channels named "a.b.R", "a.b.red"; empty for others. And "a.b".
std::string exr_base_name(const std::string& channel);
std::string exr_layer_name(const std::string& channel);
// "A, B, C and 20 more"
std::string exr_channel_list(const std::vector<std::string>& channels);

}  // namespace vitrine
