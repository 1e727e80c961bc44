// The constants of the rasteriser, each with its why. Forward and backward, reference and SIMD read them from here.
#pragma once

namespace vitrine {

// Weights below one step of an 8-bit display are dropped: this is what makes the footprint of a surfel finite.
inline constexpr double kMinAlpha = 1.0 / 255.0;
// A fragment never hides everything: 1/(1-alpha) in the reverse pass stays below 100. No gradient flows through the clamp.
inline constexpr double kMaxAlpha = 0.99;
// A fragment is blended iff the transmittance in front of it is at least this. What is behind it adds at most 1e-4.
inline constexpr double kMinTransmittance = 1e-4;
// Screen low-pass exp(-|d|^2): rho2d = 2 |d|^2, sigma = sqrt(1/2) px, so that nothing is thinner than about one pixel.
inline constexpr double kLowPassInvVariance = 2.0;
// Stands for "no low-pass": any offset from the centre is infinitely far in standard deviations.
inline constexpr double kNoLowPass = 1e30;
// A surfel whose plane passes through the eye within this angle (radians, about) is culled: in float its projection would be
// rounding noise.
inline constexpr double kEdgeOn = 1e-4;
// The median depth is where the transmittance falls through this.
inline constexpr double kMedianTransmittance = 0.5;

}  // namespace vitrine
