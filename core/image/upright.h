// EXIF orientation (EXIF 2.32, tag 0x0112): how stored pixels are turned and mirrored to be upright.
#pragma once

#include "core/image/image.h"

namespace vitrine {

// The image that a viewer shows for a stored image with EXIF orientation 1..8.
ImageF upright(const ImageF& stored, int orientation);

}  // namespace vitrine
