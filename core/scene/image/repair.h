// Repair of invalid values in floating-point images.
#pragma once

#include <string>

#include "core/scene/image/image.h"

namespace vitrine {

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
