// A region that the user marked in a photo, as YAML files of the user's have it: `photo: img_0002.jpg` with `box: [left, top,
// right, bottom]` or `polygon: [[x, y], [x, y], [x, y]]`.
#pragma once

#include <filesystem>
#include <span>

#include "core/camera/view.h"
#include "core/config/yaml_reader.h"
#include "core/math/vec.h"

namespace vitrine {

// Whether a mark calls the photo so: by its whole name, or without its folder or extension.
bool names_photo(const std::string& text, const std::filesystem::path& photo);

// The view that the node names: its whole name, or without folder or extension when one photo alone is called so. nullopt:
// complained.
std::optional<size_t> marked_view(YamlReader& in, const YamlNode& name, std::span<const View> views);

struct MarkedRegion {
  std::vector<Vec2d> corners;  // in the pixels of the file; three or more
  bool box = false;
};
std::optional<MarkedRegion> marked_region(YamlReader& in, const YamlNode& mark);

}  // namespace vitrine
