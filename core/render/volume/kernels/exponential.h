// exp(x) of floats without branches or tables: loops over arrays of rays become SIMD code, with the same bytes on every
// machine of the build's instruction set.
#pragma once

#include <bit>
#include <cstdint>

namespace vitrine {

// For x <= 0. x = (n + f) ln 2 with f in [-1/2, 1/2]; 2^f by its Taylor series to the sixth order: relative error below 2e-7.
// Below kLowest the value is that of kLowest; at -87 it is 1.6e-38, next to the smallest normal float.
template <int kLowest = -87>
inline float exponential(float x) {
  // Bits of negative floats grow with their size: an integer minimum, which no floating-point trap keeps from being a vector.
  constexpr uint32_t kLowestBits = std::bit_cast<uint32_t>(float(kLowest));
  const uint32_t bits = std::bit_cast<uint32_t>(x);
  const float t = std::bit_cast<float>(bits < kLowestBits ? bits : kLowestBits) * 1.44269504f;
  const int32_t n = static_cast<int32_t>(t - 0.5f);  // truncation rounds to nearest: t <= 0
  const float f = (t - static_cast<float>(n)) * 0.693147181f;
  float e = 1.f / 720;
  e = e * f + 1.f / 120;
  e = e * f + 1.f / 24;
  e = e * f + 1.f / 6;
  e = e * f + 0.5f;
  e = e * f + 1.f;
  e = e * f + 1.f;
  return e * std::bit_cast<float>((n + 127) << 23);
}

}  // namespace vitrine
