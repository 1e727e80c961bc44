// Which channels of an OpenEXR file are its picture. Renderers write many: layers by prefixes ("ViewLayer.Combined.R",
// "diffuse.R"), by parts with names, and by views of a stereo pair. By names alone, so that it is decided before anything is
// read.
#pragma once

#include <string>
#include <vector>

namespace vitrine {

struct ExrPart {
  std::string name, view;             // attributes of the part; empty in most files
  bool deep = false;                  // several samples per pixel
  std::vector<std::string> channels;  // as the file sorts them
};

struct ExrColors {
  size_t part = 0;
  std::vector<std::string> channels;  // R, G, B; or one of grey; or Y, RY, BY; empty when `refusal` is not
  std::string alpha;                  // of the same layer; empty when there is none
  bool luminance_chroma = false;      // Y, RY, BY
  std::string refusal;                // why there is no picture, with the names that were found
  std::vector<std::string> notes;     // what was chosen where there was a choice
};

// Order of preference: a layer (or part) called combined (composite.combined before others), beauty, rgba; channels without a
// prefix; the only layer that has R, G, B. Then grey in the same order. Of a stereo pair its first view (`views`: the attribute
// multiView).
ExrColors exr_colors(const std::vector<ExrPart>& parts, const std::vector<std::string>& views);

// "R", "G", "B" of a channel called "a.b.R", "a.b.red"; empty for others. And "a.b".
std::string exr_base_name(const std::string& channel);
std::string exr_layer_name(const std::string& channel);
// "A, B, C and 20 more"
std::string exr_channel_list(const std::vector<std::string>& channels);

}  // namespace vitrine
