// The pixels of appendages of a surface of revolution. Hulls of few marks have an appendage up to its root, and are too wide
// along the silhouette of the body beside it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

// All [h,w] of `k`, 0 or 1. `solid`: the silhouette of the body; `off`: pixels of the hulls beside it; `far`: those of them whose
// surface is far from the body. Returns the body with the far pixels and those on the way from there to it.
std::vector<uint8_t> with_appendages(const std::vector<uint8_t>& solid, const std::vector<uint8_t>& off,
                                     const std::vector<uint8_t>& far, const Intrinsics& k);

}  // namespace vitrine
