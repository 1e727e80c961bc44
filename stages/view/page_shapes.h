// Known shapes for the page: triangles that it draws (sheets of glass and polished surfaces are better known than surfels show
// them), and the planes that mirror.
#pragma once

#include "core/base/json.h"
#include "core/shape/shape_set.h"
#include "stages/view/page_blocks.h"

namespace vitrine {

// Blocks shape_place, shape_normal, shape_part (facet, entry; facet 65535: curved) of vertices, shape_corner of triangles.
// Returns
//   {"entries": [{"role", "tolerance", "closed", "exact", "parent", "object"}], "facets": [{"entry", "normal", "offset",
//   "clear", "at_pane"}]}
// Throws nothing; an empty set gives empty lists.
nlohmann::ordered_json add_shapes(const ShapeSet* set, PageBlocks& blocks);

}  // namespace vitrine
