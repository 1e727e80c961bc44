// Objects that are no simple shape: a closed mesh fitted to their silhouettes (core/stereo/mesh_fit.h), from their visual hull.
#pragma once

#include <optional>

#include "core/shape/shape_set.h"
#include "stages/shapes/objects.h"

namespace vitrine {

// Nothing where the mesh does not explain the masks: where it lies outside them, or leaves much of the hull's silhouettes.
std::optional<ShapeSet::Entry> free_form(const MaskedObject& object, ShapeRole role);

}  // namespace vitrine
