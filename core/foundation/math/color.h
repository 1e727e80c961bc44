// sRGB transfer function (IEC 61966-2-1). Radiance is linear everywhere in vitrine; it is encoded only for display, 8-bit files
// and the photometric loss.
#pragma once

#include <cmath>

namespace vitrine {

constexpr float kSrgbKnee = 0.0031308f;

template <class T> T srgb_from_linear(const T& l) {
  using std::pow;
  if (!(l > T(kSrgbKnee))) return T(12.92) * l;
  return T(1.055) * pow(l, 1.0f / 2.4f) - T(0.055);
}
// d srgb / d linear.
template <class T> T srgb_from_linear_slope(const T& l) {
  using std::pow;
  if (!(l > T(kSrgbKnee))) return T(12.92);
  return T(1.055f / 2.4f) * pow(l, 1.0f / 2.4f - 1.0f);
}
template <class T> T linear_from_srgb(const T& s) {
  using std::pow;
  if (!(s > T(0.04045f))) return s / T(12.92);
  return pow((s + T(0.055)) / T(1.055), 2.4f);
}

}  // namespace vitrine
