// Values of floating-point pictures that no light has.
#pragma once

#include <string>

#include "core/scene/image/image.h"

namespace vitrine {

struct RepairedValues {
  size_t not_numbers = 0;  // NaN and minus infinity: 0 now
  size_t too_bright = 0;   // above what half-precision files hold, infinity included: 65504 now
  size_t negative = 0;     // below `darkest`, which they are now

  size_t count() const { return not_numbers + too_bright + negative; }
  // "3 values that are no numbers were set to 0, 5 above 65504 to 65504, 12 below 0 to 0"; empty when there was nothing.
  std::string text() const;
  RepairedValues& operator+=(const RepairedValues& other);
};

RepairedValues repair_values(ImageF& image, float darkest = 0);

}  // namespace vitrine
