// The shapes that a hull knows: its solids, as surfaces of revolution, and their appendages, as meshes with a parent.
#pragma once

#include "core/shape/shape_set.h"
#include "stages/optimize/hull.h"

namespace vitrine {

// All of role Mirror. Every connected piece of Hull::beside is an appendage of the solid that it is nearest to; those of one
// solid are one entry.
ShapeSet known_shapes(const Hull& hull);

}  // namespace vitrine
