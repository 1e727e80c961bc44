// Formulas and constants of densification by relocation (densify.h), shared by the CPU and the kernels for a GPU (blocks/).
#pragma once

#include <cstdint>

#include "core/foundation/math/vec.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

// Streams of random numbers by purpose.
enum DensifyStream : uint64_t { kRelocateStream = 0x4d01, kGrowStream = 0x4d02, kNoiseStream = 0x4d04, kSplitStream = 0x4d05 };

// Surfels at or below this opacity are relocated.
inline constexpr double kDeadOpacity = 0.01;
// Fraction of the mean error: surfels without error still get a few copies.
inline constexpr double kErrorFloor = 0.1;
// Weight of one picture in SurfelAccumulator::share, and the smallest share that counts.
inline constexpr float kShareDecay = 0.01f, kRarestShare = 1e-3f;
// Halves of a divided surfel: offset of their centres, in standard deviations of the parent's longer axis, and their relative
// scales. The sum of the two halves matches the parent's profile along that axis within a quarter up to one and a half
// deviations.
inline constexpr float kHalfOffset = 0.6f, kHalfLong = 0.52f, kHalfShort = 0.95f;

// A negative channel renders black and has no gradient: the constant term of the harmonics stays above this linear radiance.
inline constexpr float kLeastColour = 1e-3f;

// p ~ o (floor + E / mean E), E the error of the pixels of a surfel: opaque surfels, and more where the picture error is large.
template <class T>
VITRINE_HD T division_chance(const T& opacity, const T& error, const T& mean_error) {
  return opacity * (mean_error > T(0) ? T(kErrorFloor) + error / mean_error : T(1));
}

// Step scale of a surfel that few photos show (SurfelAccumulator::rarity), by its share of the pictures.
template <class T>
VITRINE_HD T rarity_factor(const T& mean_share, const T& share, const T& most) {
  const T floor(kRarestShare), factor = mean_share / (share < floor ? floor : share);
  return factor < T(1) ? T(1) : most < factor ? most : factor;
}

// Step scale by distance: surfels far from the cameras move in proportion to their distance, so that a step, or a random walk,
// has the same angular size everywhere. 1 near the cameras, whose radius is 1 around the origin; beyond a few radii the
// distance divided by that limit.
template <class T>
VITRINE_HD T far_factor(const Vec3<T>& mean) {
  using std::sqrt;
  constexpr float kFar = 5;
  const T factor = sqrt(mean.x * mean.x + mean.y * mean.y + mean.z * mean.z) / T(kFar);
  return T(1) < factor ? factor : T(1);
}

// Random walk of nearly transparent surfels (add_position_noise): share of its strength by opacity.
template <class T>
VITRINE_HD T noise_gate(const T& opacity) {
  constexpr float kSteepness = 100.f, kThreshold = 0.005f;
  return sigmoid(T(kSteepness) * (T(kThreshold) - opacity));
}
struct NoiseRule {
  static constexpr float kLeastGate = 1e-4f;  // surfels below it stay
};

}  // namespace vitrine
