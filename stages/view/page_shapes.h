// Known shapes for the page: triangles, which are more accurate than surfels for sheets of glass and for mirrors, and
// mirror planes.
#pragma once

#include "core/foundation/base/json.h"
#include "core/scene/shape/shape_set.h"
#include "stages/view/page_blocks.h"

namespace vitrine {

// Writes blocks shape_place, shape_normal, shape_part (facet, entry; facet 65535: curved) of vertices, shape_corner of triangles.
// Returns
//   {"entries": [{"role", "tolerance", "closed", "exact", "parent", "object"}], "facets": [{"entry", "normal", "offset",
//   "clear", "at_pane"}]}
// An empty set gives empty lists.
nlohmann::ordered_json add_shapes(const ShapeSet* set, PageBlocks& blocks);

}  // namespace vitrine
