// Data for previewing edits in the page as `vitrine edit` would apply them (core/render/edit): mask classes and mesh component of
// every surfel, positions of surfels that the page does not render, and the surfels of each known shape.
#pragma once

#include <span>

#include "core/foundation/base/json.h"
#include "core/render/edit/edit_scene.h"
#include "core/scene/objects/object_labels.h"
#include "core/scene/objects/object_set.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

// Writes the block part_object: id of the object of each rendered surfel, 0: none. Without objects there is no block. Returns the
// list [{"id", "name", "role", "trust"}].
nlohmann::ordered_json add_objects(const ObjectSet& set, const SplatScene& scene, const PageSurfels& surfels, PageBlocks& blocks);

// Writes blocks. part_class and part_component of the rendered surfels (class: one bit each, in the order of kMaskClasses;
// component 0: none, or beyond 255). absent_place, absent_class, absent_component, absent_flags and, if there are objects,
// absent_object (like part_object) of the diffuse surfels that are not rendered. shape_surfel: surfels of each
// entry of `shapes` (page_shapes.h), as indices into the rendered surfels followed by the absent ones; the entry gets their count
// as "surfels". Returns {"there": true, "classes": names, "no_classes": reason if there are none, "components": count}.
nlohmann::ordered_json add_edits(const EditScene& scene, std::span<const View> views, const ClassPixels& pixels,
                                 const PageSurfels& surfels, nlohmann::ordered_json& shapes, PageBlocks& blocks);

// For a page without edits; `why` is the reason.
nlohmann::ordered_json no_edits(const std::string& why);

}  // namespace vitrine
