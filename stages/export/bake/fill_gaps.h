// Fills the texels that nothing was baked into with what is near them: averages of known texels, coarser and coarser, then back
// (pull-push). Filtering and mip maps at the borders of charts then mix like with like.
#pragma once

#include <span>

#include "core/image/image.h"

namespace vitrine {

// known: [h, w], not zero where the image holds a value. All of it unknown: black.
void fill_gaps(Image8& image, std::span<const uint8_t> known);

}  // namespace vitrine
