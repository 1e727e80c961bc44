// A region that the user marked in a photo, as YAML files of the user's have it: `photo: img_0002.jpg` with `box: [left, top,
// right, bottom]` or `polygon: [[x, y], [x, y], [x, y]]`.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/foundation/config/yaml_reader.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

// The view that the node names: its whole name, or a part of it that means one photo alone (core/foundation/config/photo_name_finder.h).
// nullopt: complained.
std::optional<size_t> marked_view(YamlReader& in, const YamlNode& name, std::span<const View> views);

// Marks in photos from one side do not tell how far away a thing is: length of the mean direction from it towards their cameras,
// that of two photos 20 degrees apart.
inline constexpr double kMostOneSided = 0.985;

struct MarkedRegion {
  std::vector<Vec2d> corners;  // in the pixels of the file; three or more
  bool box = false;
};
// A box that is none, an outline that crosses itself or encloses nothing: nullopt, complained at its corner.
std::optional<MarkedRegion> marked_region(YamlReader& in, const YamlNode& mark);
// Where the file has that corner of the mark's region: what complaints about it point at.
const YamlNode& corner_node(const YamlNode& mark, size_t corner);

}  // namespace vitrine
