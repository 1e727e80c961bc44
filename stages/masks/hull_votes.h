// Masks of single photos, carried through space: what is left of the visual hull of all of them (core/stereo/visual_hull.h) is
// seen by every camera. Sources whose photos do not know of each other let them vote this way.
#pragma once

#include <cstdint>
#include <vector>

#include "core/stereo/visual_hull.h"

namespace vitrine {

// [h,w] 1 = belongs, of the size of `view`.
HullMask hull_mask(const View& view, const std::vector<uint8_t>& inside);
// [view][h,w] 1 where the view's ray meets the hull.
std::vector<std::vector<uint8_t>> silhouettes(const VisualHull& hull, const std::vector<View>& views);

}  // namespace vitrine
