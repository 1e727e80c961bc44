// Pixels of views cut from fisheye photos that the lens does not show (core/scene/camera/wide_views.h): no photo observed them,
// so they belong to the class `ignore`.
#pragma once

#include <memory>

#include "stages/masks/mask_source.h"

namespace vitrine {

// Adds these pixels to `ignore`, the source of the class, which may be empty. Unchanged if all pixels are seen.
void add_unseen_pixels(const MaskCapture& capture, std::unique_ptr<MaskSource>& ignore);

}  // namespace vitrine
