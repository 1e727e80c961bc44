// Parses user-marked regions of a photo from YAML: `photo: img_0002.jpg` with `box: [left, top, right, bottom]` or
// `polygon: [[x, y], [x, y], [x, y]]`.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/foundation/config/yaml.h"
#include "core/foundation/math/vec.h"
#include "core/scene/camera/view.h"

namespace vitrine {

// The view named by the node: its full name, or a unique part of it (core/foundation/config/photo_name_finder.h). nullopt: an
// error was reported.
std::optional<size_t> marked_view(YamlReader& in, const YamlNode& name, std::span<const View> views);

// Upper limit on the length of the mean direction from an object towards the cameras of its marks: two photos 20 degrees apart.
// Marks from one side do not constrain the object's distance.
inline constexpr double kMostOneSided = 0.985;

struct MarkedRegion {
  std::vector<Vec2d> corners;  // in pixels of the file; three or more
  bool box = false;
};
// nullopt for an invalid box, or an outline that crosses itself or has no area; the error is reported at its corner.
std::optional<MarkedRegion> marked_region(YamlReader& in, const YamlNode& mark);
// The YAML node of that corner of the mark's region, for error positions.
const YamlNode& corner_node(const YamlNode& mark, size_t corner);

}  // namespace vitrine
