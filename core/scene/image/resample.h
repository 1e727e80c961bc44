// Image resampling in linear light, and EXIF orientation.
#pragma once

#include <string>

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

// Repair of invalid values in floating-point images.
struct RepairedValues {
  size_t not_numbers = 0;  // NaN and minus infinity, set to 0
  size_t too_bright = 0;   // above the half-float maximum, including infinity, set to 65504
  size_t negative = 0;     // below `darkest`, set to it

  size_t count() const { return not_numbers + too_bright + negative; }
  // "3 values that are no numbers were set to 0, 5 above 65504 to 65504, 12 below 0 to 0"; empty if nothing was changed.
  std::string text() const;
  RepairedValues& operator+=(const RepairedValues& other);
};

RepairedValues repair_values(ImageF& image, float darkest = 0);

}  // namespace vitrine
