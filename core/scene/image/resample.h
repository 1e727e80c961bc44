// Images resized, in linear light, and turned.
#pragma once

#include "core/scene/image/image.h"

namespace vitrine {

// Exact area average (box of the true, fractional footprint) for shrinking; bilinear when enlarging.
ImageF resized(const ImageF& image, int width, int height);
// Bilinear lookup at pixel coordinates (centres at .5), clamped at the border. out[channels].
void sample_bilinear(const ImageF& image, double x, double y, float* out);
// Catmull-Rom bicubic lookup, clamped to the border and to the range of the four nearest pixels (no ringing).
void sample_bicubic(const ImageF& image, double x, double y, float* out);

// The image that a viewer shows for a stored image with EXIF orientation 1..8 (EXIF 2.32, tag 0x0112), which says how stored
// pixels are turned and mirrored to be upright.
ImageF upright(const ImageF& stored, int orientation);

}  // namespace vitrine
