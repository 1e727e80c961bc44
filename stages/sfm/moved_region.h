// Without masks of the object: which points of a model belong to something that was moved between the photos before and after
// some place in name order?
//
// Cameras before and after that place look at a point from nearly the same direction. What stands still is found on both sides:
// tracks of its points span the place. What was moved looks different from the same direction: no track of its points does. The
// place at which most points are surrounded by points without such tracks is taken; all other points around must span it freely.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/colmap_model.h"

namespace vitrine {

// [model.points] 1: of the moved region. Empty: nothing was moved.
std::vector<uint8_t> moved_region(const ColmapModel& model);

}  // namespace vitrine
