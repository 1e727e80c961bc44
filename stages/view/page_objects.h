// The objects of a scene (core/objects) for its page: their list, and the one that each drawn surfel belongs to.
#pragma once

#include "core/base/json.h"
#include "core/objects/object_set.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

// Block part_object: the stored id of each drawn surfel, 0: none. Without objects there is no block. Returns the list
// [{"id", "name", "role", "trust"}].
nlohmann::ordered_json add_objects(const ObjectSet& set, const SplatScene& scene, const PageSurfels& surfels, PageBlocks& blocks);

}  // namespace vitrine
