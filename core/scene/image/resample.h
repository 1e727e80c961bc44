// Image resampling in linear light, and EXIF orientation.
#pragma once

#include "core/scene/image/image.h"

namespace vitrine {

// Shrinking: exact area average (box filter of the fractional footprint). Enlarging: bilinear.
ImageF resized(const ImageF& image, int width, int height);
// Bilinear lookup at pixel coordinates (centres at .5), clamped at the border. out[channels].
void sample_bilinear(const ImageF& image, double x, double y, float* out);
// Catmull-Rom bicubic lookup, clamped to the border and to the range of the four nearest pixels (no ringing).
void sample_bicubic(const ImageF& image, double x, double y, float* out);

// Applies EXIF orientation 1..8 (EXIF 2.32, tag 0x0112): rotates and mirrors the stored image to upright.
ImageF upright(const ImageF& stored, int orientation);

}  // namespace vitrine
