// Channel selection for OpenEXR files. Renderers write many layers: by prefix ("ViewLayer.Combined.R", "diffuse.R"), by part
// name, and by stereo view. The selection uses names only and needs no pixels.
#pragma once

#include <string>
#include <vector>

namespace vitrine {

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
