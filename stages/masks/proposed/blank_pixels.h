// Pixels of cut-out photos that show nothing: outside their alpha, where the file has one colour.
#pragma once

#include <vector>

#include "stages/masks/mask_source.h"

namespace vitrine {

// [h,w]: 1 where the photo has the commonest colour of its border, over at least 3 x 3 pixels, and two pixels around. All 0 if
// less than a tenth of the border has one colour.
std::vector<uint8_t> blank_pixels(const SmallPhoto& photo);

}  // namespace vitrine
