// What sticks out of a solid in a picture, an appendage, and where it ends: hulls of few marks have it up to its root, and too
// much along the solid's outline beside it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/camera/view.h"

namespace vitrine {

// All [h,w] of `k`, 0 or 1. `solid`: its outline, filled; `off`: what hulls have besides; `far`: what of it stands far off.
// Returns the solid with what is far and what lies on the way from there to it.
std::vector<uint8_t> with_appendages(const std::vector<uint8_t>& solid, const std::vector<uint8_t>& off,
                                     const std::vector<uint8_t>& far, const Intrinsics& k);

}  // namespace vitrine
