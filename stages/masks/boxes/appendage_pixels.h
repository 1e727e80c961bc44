// Pixels of the appendages of a surface of revolution. A visual hull of few marks contains an appendage up to its root, but is
// too wide along the silhouette of the body next to it.
#pragma once

#include <cstdint>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

// All images are [h,w] of `k`, 0 or 1. `solid`: silhouette of the body; `off`: hull pixels outside it; `far`: those of them whose
// surface is far from the body. Returns the body, the far pixels and the pixels that connect them to the body.
std::vector<uint8_t> with_appendages(const std::vector<uint8_t>& solid, const std::vector<uint8_t>& off,
                                     const std::vector<uint8_t>& far, const Intrinsics& k);

}  // namespace vitrine
