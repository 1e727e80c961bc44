// SIMD type of eight floats in an AVX2 register, with the operators that the kernels require of a scalar. All lanes use the
// same operations, so that the result of a hit does not depend on its neighbours.
#pragma once

#include <immintrin.h>

#include <cstdint>

#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine::embree {

struct M8 {
  __m256 m;
  friend M8 operator&(M8 a, M8 b) { return {_mm256_and_ps(a.m, b.m)}; }
};
VITRINE_INLINE uint32_t bits(M8 m) { return static_cast<uint32_t>(_mm256_movemask_ps(m.m)); }

struct V8 {
  __m256 v;
  V8() : v(_mm256_setzero_ps()) {}
  V8(__m256 x) : v(x) {}                 // NOLINT
  V8(float x) : v(_mm256_set1_ps(x)) {}  // NOLINT: implicit broadcast of constants is intended
  friend V8 operator+(V8 a, V8 b) { return _mm256_add_ps(a.v, b.v); }
  friend V8 operator-(V8 a, V8 b) { return _mm256_sub_ps(a.v, b.v); }
  friend V8 operator*(V8 a, V8 b) { return _mm256_mul_ps(a.v, b.v); }
  friend V8 operator/(V8 a, V8 b) { return _mm256_div_ps(a.v, b.v); }
  friend M8 operator<(V8 a, V8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LT_OQ)}; }
  friend M8 operator>(V8 a, V8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GT_OQ)}; }
  friend M8 operator<=(V8 a, V8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_LE_OQ)}; }
  friend M8 operator>=(V8 a, V8 b) { return {_mm256_cmp_ps(a.v, b.v, _CMP_GE_OQ)}; }
};
VITRINE_INLINE V8 select(M8 m, V8 a, V8 b) { return _mm256_blendv_ps(b.v, a.v, m.m); }
VITRINE_INLINE V8 sqrt(V8 x) { return _mm256_sqrt_ps(x.v); }

// exp(-rho/2): a power of two times a polynomial, within 2e-7 of the value; 0 for large rho.
VITRINE_INLINE V8 gaussian(V8 rho) {
  constexpr float kToPowersOfTwo = -0.5f * 1.44269504088896341f;
  const V8 x = _mm256_max_ps((rho * V8(kToPowersOfTwo)).v, _mm256_set1_ps(-126.f));
  const V8 whole = _mm256_round_ps(x.v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC), f = x - whole;
  V8 p(1.5403530e-4f);  // Taylor of 2^f
  p = p * f + V8(1.3333558e-3f);
  p = p * f + V8(9.6181291e-3f);
  p = p * f + V8(5.5504109e-2f);
  p = p * f + V8(2.4022651e-1f);
  p = p * f + V8(6.9314718e-1f);
  p = p * f + V8(1.f);
  const __m256i power = _mm256_slli_epi32(_mm256_add_epi32(_mm256_cvtps_epi32(whole.v), _mm256_set1_epi32(127)), 23);
  return p * V8(_mm256_castsi256_ps(power));
}

// columns[j] = j-th of eight consecutive floats at each of the eight addresses.
VITRINE_INLINE void load_columns(const float* const at[8], size_t offset, V8 columns[8]) {
  __m256 t[8], u[8];
  for (int i = 0; i < 4; ++i) {
    const __m256 a = _mm256_load_ps(at[2 * i] + offset), b = _mm256_load_ps(at[2 * i + 1] + offset);
    t[2 * i] = _mm256_unpacklo_ps(a, b);
    t[2 * i + 1] = _mm256_unpackhi_ps(a, b);
  }
  for (int i = 0; i < 2; ++i) {
    u[4 * i] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0x44);
    u[4 * i + 1] = _mm256_shuffle_ps(t[4 * i], t[4 * i + 2], 0xee);
    u[4 * i + 2] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0x44);
    u[4 * i + 3] = _mm256_shuffle_ps(t[4 * i + 1], t[4 * i + 3], 0xee);
  }
  for (int i = 0; i < 4; ++i) {
    columns[i] = _mm256_permute2f128_ps(u[i], u[i + 4], 0x20);
    columns[i + 4] = _mm256_permute2f128_ps(u[i], u[i + 4], 0x31);
  }
}

}  // namespace vitrine::embree
