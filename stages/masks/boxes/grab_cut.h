// The outline of a thing that differs in colour from what surrounds it, near where a hull says that it is.
#pragma once

#include <cstdint>
#include <vector>

#include "stages/masks/small_photo.h"

namespace vitrine {

// [h,w] 1 = thing. `about`: the hull's silhouette; `tight`: only near its edge is there a doubt, its middle is the thing whatever
// its colours (those of polished metal are its surroundings'). Empty when the silhouette has next to no pixels, touches
// everything, or what is found has little to do with it.
std::vector<uint8_t> grab_cut(const SmallPhoto& photo, const std::vector<uint8_t>& about, bool tight);

}  // namespace vitrine
