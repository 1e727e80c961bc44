// Objects of a scene (core/scene/objects) for its page: the list, and the object of each rendered surfel.
#pragma once

#include "core/foundation/base/json.h"
#include "core/scene/objects/object_set.h"
#include "stages/view/page_surfels.h"

namespace vitrine {

// Writes the block part_object: id of the object of each rendered surfel, 0: none. Without objects there is no block. Returns the
// list [{"id", "name", "role", "trust"}].
nlohmann::ordered_json add_objects(const ObjectSet& set, const SplatScene& scene, const PageSurfels& surfels, PageBlocks& blocks);

}  // namespace vitrine
