// Operations with different implementations for scalars and SIMD vectors. A SIMD type provides its own overloads (found by
// ADL): select(mask, a, b), gaussian(rho), reciprocal(x).
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"

// The per-fragment kernels return structs of SIMD registers: without inlining they would pass through memory.
#define VITRINE_INLINE VITRINE_HD inline __attribute__((always_inline))

namespace vitrine {

template <class T>
VITRINE_HD T select(bool condition, const T& a, const T& b) {
  return condition ? a : b;
}
// exp(-rho/2)
template <class T>
VITRINE_HD T gaussian(const T& rho) {
  using std::exp;
  return exp(T(-0.5) * rho);
}
template <class T>
VITRINE_HD T reciprocal(const T& x) {
  return T(1) / x;
}

// Constants of the rasteriser, each with its reason. Shared by forward and backward, reference and SIMD.

// Weights below one step of an 8-bit display are dropped: this makes the footprint of a surfel finite.
inline constexpr double kMinAlpha = 1.0 / 255.0;
// A fragment is never fully opaque: 1/(1-alpha) in the reverse pass is at most 100. No gradient flows through the clamp.
inline constexpr double kMaxAlpha = 0.99;
// A fragment is blended iff the transmittance in front of it is at least this. Later fragments add at most 1e-4.
inline constexpr double kMinTransmittance = 1e-4;
// Screen low-pass exp(-|d|^2): rho2d = 2 |d|^2, sigma = sqrt(1/2) px: the minimum width of a surfel is about one pixel.
inline constexpr double kLowPassInvVariance = 2.0;
// Disables the low-pass: any offset from the centre is infinitely far in standard deviations.
inline constexpr double kNoLowPass = 1e30;
// A surfel whose plane passes through the eye within this angle (about radians) is culled: in float its projection would be
// rounding noise.
inline constexpr double kEdgeOn = 1e-4;
// The median depth is where the transmittance falls below this.
inline constexpr double kMedianTransmittance = 0.5;

}  // namespace vitrine
