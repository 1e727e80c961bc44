// A float whose operations give the same bytes on every CPU and every CUDA device: each rounds once, to nearest even (IEEE 754).
// Products are never contracted with the sum behind them; a fused multiply-add is written `fma`. exp and log are polynomials.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>

#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine::blocks {

struct F32 {
  float v;

  F32() = default;
  VITRINE_HD F32(float value) : v(value) {}  // NOLINT: constants convert silently on purpose
  VITRINE_HD explicit F32(double value) : v(static_cast<float>(value)) {}
  VITRINE_HD explicit F32(int value) : v(static_cast<float>(value)) {}
  VITRINE_HD friend F32 operator+(F32 a, F32 b) { return a.v + b.v; }
  VITRINE_HD friend F32 operator-(F32 a, F32 b) { return a.v - b.v; }
  VITRINE_HD friend F32 operator*(F32 a, F32 b) {
#ifdef __CUDA_ARCH__
    return __fmul_rn(a.v, b.v);
#else
    float product = a.v * b.v;
    asm("" : "+x"(product));  // no instruction: the compiler cannot make a fused multiply-add of it, whatever its options
    return product;
#endif
  }
  VITRINE_HD friend F32 operator/(F32 a, F32 b) { return a.v / b.v; }
  VITRINE_HD F32 operator-() const { return -v; }
  VITRINE_HD F32& operator+=(F32 b) { return *this = *this + b; }
  VITRINE_HD F32& operator-=(F32 b) { return *this = *this - b; }
  VITRINE_HD F32& operator*=(F32 b) { return *this = *this * b; }
  VITRINE_HD friend bool operator<(F32 a, F32 b) { return a.v < b.v; }
  VITRINE_HD friend bool operator>(F32 a, F32 b) { return a.v > b.v; }
  VITRINE_HD friend bool operator<=(F32 a, F32 b) { return a.v <= b.v; }
  VITRINE_HD friend bool operator>=(F32 a, F32 b) { return a.v >= b.v; }
  VITRINE_HD friend bool operator==(F32 a, F32 b) { return a.v == b.v; }
};

VITRINE_HD inline uint32_t float_bits(float x) {
  uint32_t bits;
  memcpy(&bits, &x, sizeof bits);
  return bits;
}
VITRINE_HD inline float float_from_bits(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

VITRINE_HD inline F32 fma(F32 a, F32 b, F32 c) {
#ifdef __CUDA_ARCH__
  return __fmaf_rn(a.v, b.v, c.v);
#else
  return __builtin_fmaf(a.v, b.v, c.v);
#endif
}
VITRINE_HD inline F32 sqrt(F32 x) {
#ifdef __CUDA_ARCH__
  return __fsqrt_rn(x.v);
#else
  return __builtin_sqrtf(x.v);
#endif
}
VITRINE_HD inline F32 min(F32 a, F32 b) { return a.v < b.v ? a : b; }
VITRINE_HD inline F32 max(F32 a, F32 b) { return a.v > b.v ? a : b; }
VITRINE_HD inline F32 clamp(F32 x, F32 low, F32 high) { return min(max(x, low), high); }
VITRINE_HD inline F32 absolute(F32 x) { return float_from_bits(float_bits(x.v) & 0x7fffffffu); }

// 2^x for |x| <= 126, relative error 8e-8; lower x count as -126. The polynomial interpolates at Chebyshev nodes.
VITRINE_HD inline F32 exp2_below_126(F32 x) {
  x = max(x, F32(-126.f));
  const F32 whole = rintf(x.v), f = x - whole;
  F32 p(1.33908634e-3f);
  p = fma(p, f, F32(9.67603192e-3f));
  p = fma(p, f, F32(5.55035711e-2f));
  p = fma(p, f, F32(2.40221075e-1f));
  p = fma(p, f, F32(6.93147188e-1f));
  p = fma(p, f, F32(1.00000008f));
  return p * F32(float_from_bits(static_cast<uint32_t>(static_cast<int>(whole.v) + 127) << 23));
}
VITRINE_HD inline F32 exp(F32 x) { return exp2_below_126(min(x * F32(1.44269504f), F32(126.f))); }
VITRINE_HD inline F32 gaussian(F32 rho) { return exp2_below_126(rho * F32(-0.5f * 1.44269504f)); }

// ln((1 + s) / (1 - s)) for |s| <= 0.172, relative error 2e-7.
VITRINE_HD inline F32 log_of_ratio(F32 s) {
  const F32 ss = s * s;
  F32 p(2.f / 9);
  p = fma(p, ss, F32(2.f / 7));
  p = fma(p, ss, F32(2.f / 5));
  p = fma(p, ss, F32(2.f / 3));
  return fma(p * ss, s, s + s);
}
// Natural logarithm of positive normal values, relative error 3e-7.
VITRINE_HD inline F32 log(F32 x) {
  const uint32_t bits = float_bits(x.v);
  const int exponent = static_cast<int>(bits - float_bits(0.707106781f)) >> 23;
  const F32 m(float_from_bits(bits - (static_cast<uint32_t>(exponent) << 23)));  // between sqrt(1/2) and sqrt(2)
  return fma(F32(exponent), F32(0.693147181f), log_of_ratio((m - F32(1.f)) / (m + F32(1.f))));
}
// The same with an absolute error of 1.2e-5.
VITRINE_HD inline F32 log_of(F32 x) {
  const uint32_t bits = float_bits(x.v);
  const F32 m = F32(float_from_bits((bits & 0x007fffffu) | 0x3f800000u)) - F32(1.5f);
  const F32 exponent(static_cast<int>(bits >> 23) - 127);
  F32 p(2.98087652e-2f);
  p = fma(p, m, F32(-5.54352845e-2f));
  p = fma(p, m, F32(9.84307009e-2f));
  p = fma(p, m, F32(-2.21639156e-1f));
  p = fma(p, m, F32(6.66671338e-1f));
  p = fma(p, m, F32(4.05456972e-1f));
  return fma(exponent, F32(0.693147181f), p);
}
}  // namespace vitrine::blocks
