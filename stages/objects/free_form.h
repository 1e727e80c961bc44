// Objects that are no simple shape: a closed mesh fitted to their silhouettes (core/stereo/mesh_fit.h), from their visual hull.
#pragma once

#include <optional>

#include "core/shape/shape_set.h"
#include "stages/objects/masked_objects.h"

namespace vitrine {

// Nothing where 15 % or more of the mesh's pixels lie outside the masks.
std::optional<ShapeSet::Entry> free_form(const MaskedObject& object, ShapeRole role);

}  // namespace vitrine
