// What the page must know to preview edits as `vitrine edit` would make them (core/edit): classes of the masks and components of
// the mesh of every surfel, where surfels are that the page does not draw, and which surfels show which known shape.
#pragma once

#include <span>

#include "core/base/json.h"
#include "core/edit/edit_scene.h"
#include "core/objects/object_labels.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

// Blocks part_class and part_component of the drawn surfels (a bit a class in the order of kMaskClasses; 0: no component, or one
// beyond 255), absent_place, absent_class, absent_component, absent_flags and, where there are objects, absent_object (as
// part_object, page_objects.h) of those of the diffuse layer that are not drawn, and shape_surfel: of each entry of `shapes`
// (page_shapes.h), which gets their number as "surfels", the indices among both.
// Returns {"there": true, "classes": names, "no_classes": why there are none, "components": how many}.
nlohmann::ordered_json add_edits(const EditScene& scene, std::span<const View> views, const ClassPixels& pixels,
                                 const PageSurfels& surfels, nlohmann::ordered_json& shapes, PageBlocks& blocks);

// In a page without edits: why.
nlohmann::ordered_json no_edits(const std::string& why);

}  // namespace vitrine
