// Sixteen floats in two AVX2 registers: the same interface as simd_avx512.h.
#pragma once

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine::avx2 {

struct M16 {
  __m256 a, b;
  friend M16 operator&(M16 x, M16 y) { return {_mm256_and_ps(x.a, y.a), _mm256_and_ps(x.b, y.b)}; }
  friend M16 operator|(M16 x, M16 y) { return {_mm256_or_ps(x.a, y.a), _mm256_or_ps(x.b, y.b)}; }
  M16 operator~() const {
    const __m256 ones = _mm256_castsi256_ps(_mm256_set1_epi32(-1));
    return {_mm256_xor_ps(a, ones), _mm256_xor_ps(b, ones)};
  }
};
VITRINE_INLINE uint32_t bits(M16 m) {
  return static_cast<uint32_t>(_mm256_movemask_ps(m.a)) | static_cast<uint32_t>(_mm256_movemask_ps(m.b)) << 8;
}
VITRINE_INLINE bool any(M16 m) { return _mm256_movemask_ps(_mm256_or_ps(m.a, m.b)) != 0; }
VITRINE_INLINE M16 mask_from_bits(uint32_t b) {
  const __m256i low = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128), high = _mm256_slli_epi32(low, 8);
  const __m256i all = _mm256_set1_epi32(static_cast<int>(b));
  return {_mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(all, low), low)),
          _mm256_castsi256_ps(_mm256_cmpeq_epi32(_mm256_and_si256(all, high), high))};
}

struct F16 {
  __m256 a, b;
  F16() : a(_mm256_setzero_ps()), b(_mm256_setzero_ps()) {}
  F16(__m256 x, __m256 y) : a(x), b(y) {}
  F16(float x) : a(_mm256_set1_ps(x)), b(a) {}  // NOLINT: implicit broadcast of constants is intended
  friend F16 operator+(F16 x, F16 y) { return {_mm256_add_ps(x.a, y.a), _mm256_add_ps(x.b, y.b)}; }
  friend F16 operator-(F16 x, F16 y) { return {_mm256_sub_ps(x.a, y.a), _mm256_sub_ps(x.b, y.b)}; }
  friend F16 operator*(F16 x, F16 y) { return {_mm256_mul_ps(x.a, y.a), _mm256_mul_ps(x.b, y.b)}; }
  friend F16 operator/(F16 x, F16 y) { return {_mm256_div_ps(x.a, y.a), _mm256_div_ps(x.b, y.b)}; }
  F16 operator-() const { return F16(0.f) - *this; }
  F16& operator+=(F16 y) { return *this = *this + y; }
  F16& operator-=(F16 y) { return *this = *this - y; }
  F16& operator*=(F16 y) { return *this = *this * y; }
  friend M16 operator<(F16 x, F16 y) { return {_mm256_cmp_ps(x.a, y.a, _CMP_LT_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_LT_OQ)}; }
  friend M16 operator>(F16 x, F16 y) { return {_mm256_cmp_ps(x.a, y.a, _CMP_GT_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_GT_OQ)}; }
  friend M16 operator<=(F16 x, F16 y) { return {_mm256_cmp_ps(x.a, y.a, _CMP_LE_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_LE_OQ)}; }
  friend M16 operator>=(F16 x, F16 y) { return {_mm256_cmp_ps(x.a, y.a, _CMP_GE_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_GE_OQ)}; }
  friend M16 operator==(F16 x, F16 y) { return {_mm256_cmp_ps(x.a, y.a, _CMP_EQ_OQ), _mm256_cmp_ps(x.b, y.b, _CMP_EQ_OQ)}; }
};
VITRINE_INLINE F16 load(const float* p) { return {_mm256_load_ps(p), _mm256_load_ps(p + 8)}; }
VITRINE_INLINE void store(float* p, F16 x) {
  _mm256_store_ps(p, x.a);
  _mm256_store_ps(p + 8, x.b);
}
VITRINE_INLINE void store_rows(float* p, size_t stride, F16 x) {
  _mm256_storeu2_m128(p + stride, p, x.a);
  _mm256_storeu2_m128(p + 3 * stride, p + 2 * stride, x.b);
}
VITRINE_INLINE F16 load_first(const float* p, uint32_t count) {
  if (count >= 16) return {_mm256_loadu_ps(p), _mm256_loadu_ps(p + 8)};
  alignas(32) float lanes[16] = {};
  for (uint32_t i = 0; i < count; ++i) lanes[i] = p[i];
  return load(lanes);
}
VITRINE_INLINE void store_first(float* p, uint32_t count, F16 x) {
  if (count >= 16) {
    _mm256_storeu_ps(p, x.a);
    _mm256_storeu_ps(p + 8, x.b);
    return;
  }
  alignas(32) float lanes[16];
  store(lanes, x);
  for (uint32_t i = 0; i < count; ++i) p[i] = lanes[i];
}
VITRINE_INLINE F16 iota() { return {_mm256_setr_ps(0, 1, 2, 3, 4, 5, 6, 7), _mm256_setr_ps(8, 9, 10, 11, 12, 13, 14, 15)}; }
VITRINE_INLINE F16 select(M16 m, F16 x, F16 y) { return {_mm256_blendv_ps(y.a, x.a, m.a), _mm256_blendv_ps(y.b, x.b, m.b)}; }
VITRINE_INLINE F16 add_where(M16 m, F16 x, F16 y) { return {x.a + _mm256_and_ps(m.a, y.a), x.b + _mm256_and_ps(m.b, y.b)}; }
VITRINE_INLINE F16 multiply_where(M16 m, F16 x, F16 y) { return select(m, x * y, x); }
VITRINE_INLINE F16 dim_where(M16 m, F16 x, F16 y) {
  return {_mm256_fnmadd_ps(x.a, _mm256_and_ps(m.a, y.a), x.a), _mm256_fnmadd_ps(x.b, _mm256_and_ps(m.b, y.b), x.b)};
}
VITRINE_INLINE F16 min(F16 x, F16 y) { return {_mm256_min_ps(x.a, y.a), _mm256_min_ps(x.b, y.b)}; }
VITRINE_INLINE F16 max(F16 x, F16 y) { return {_mm256_max_ps(x.a, y.a), _mm256_max_ps(x.b, y.b)}; }
VITRINE_INLINE F16 sqrt(F16 x) { return {_mm256_sqrt_ps(x.a), _mm256_sqrt_ps(x.b)}; }
VITRINE_INLINE F16 reciprocal(F16 x) {
  const F16 r{_mm256_rcp_ps(x.a), _mm256_rcp_ps(x.b)};
  return r * (F16(2.f) - x * r);
}
VITRINE_INLINE F16 next_above(F16 x) {
  const __m256i one = _mm256_set1_epi32(1);
  return {_mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(x.a), one)),
          _mm256_castsi256_ps(_mm256_add_epi32(_mm256_castps_si256(x.b), one))};
}
VITRINE_INLINE F16 spread_pair(F16 x, int pair) {
  const __m256 source = pair < 4 ? x.a : x.b;
  const int lane = 2 * (pair % 4);
  return {_mm256_permutevar8x32_ps(source, _mm256_set1_epi32(lane)),
          _mm256_permutevar8x32_ps(source, _mm256_set1_epi32(lane + 1))};
}
VITRINE_INLINE F16 round_nearest(F16 x) {
  constexpr int kMode = _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC;
  return {_mm256_round_ps(x.a, kMode), _mm256_round_ps(x.b, kMode)};
}
VITRINE_INLINE __m256 power_of_two(__m256 e) {
  return _mm256_castsi256_ps(_mm256_slli_epi32(_mm256_add_epi32(_mm256_cvtps_epi32(e), _mm256_set1_epi32(127)), 23));
}
VITRINE_INLINE F16 scale_by_power(F16 x, F16 e) { return x * F16(power_of_two(e.a), power_of_two(e.b)); }
VITRINE_INLINE __m256 exponent8(__m256 x) {
  return _mm256_cvtepi32_ps(_mm256_sub_epi32(_mm256_srli_epi32(_mm256_castps_si256(x), 23), _mm256_set1_epi32(127)));
}
VITRINE_INLINE F16 exponent(F16 x) { return {exponent8(x.a), exponent8(x.b)}; }
VITRINE_INLINE __m256 mantissa8(__m256 x) {
  const __m256 fraction = _mm256_and_ps(x, _mm256_castsi256_ps(_mm256_set1_epi32(0x007fffff)));
  return _mm256_or_ps(fraction, _mm256_set1_ps(1.f));
}
VITRINE_INLINE F16 mantissa(F16 x) { return {mantissa8(x.a), mantissa8(x.b)}; }
VITRINE_INLINE F16 absolute(F16 x) {
  const __m256 keep = _mm256_castsi256_ps(_mm256_set1_epi32(0x7fffffff));
  return {_mm256_and_ps(x.a, keep), _mm256_and_ps(x.b, keep)};
}

VITRINE_INLINE void columns_of8(__m256 a, __m256 b, __m256 c, __m256 d, __m256 out[4]) {
  const __m256d t0 = _mm256_castps_pd(_mm256_unpacklo_ps(a, b)), t1 = _mm256_castps_pd(_mm256_unpackhi_ps(a, b));
  const __m256d t2 = _mm256_castps_pd(_mm256_unpacklo_ps(c, d)), t3 = _mm256_castps_pd(_mm256_unpackhi_ps(c, d));
  out[0] = _mm256_castpd_ps(_mm256_unpacklo_pd(t0, t2));
  out[1] = _mm256_castpd_ps(_mm256_unpackhi_pd(t0, t2));
  out[2] = _mm256_castpd_ps(_mm256_unpacklo_pd(t1, t3));
  out[3] = _mm256_castpd_ps(_mm256_unpackhi_pd(t1, t3));
}
VITRINE_INLINE void columns_of(F16 a, F16 b, F16 c, F16 d, F16 out[4]) {
  __m256 low[4], high[4];
  columns_of8(a.a, b.a, c.a, d.a, low);
  columns_of8(a.b, b.b, c.b, d.b, high);
  for (int j = 0; j < 4; ++j) out[j] = F16(low[j], high[j]);
}
VITRINE_INLINE F16 pair_columns(F16 x, F16 y) {
  return {_mm256_unpacklo_ps(x.a, y.a) + _mm256_unpackhi_ps(x.a, y.a),
          _mm256_unpacklo_ps(x.b, y.b) + _mm256_unpackhi_ps(x.b, y.b)};
}
VITRINE_INLINE F16 fold_halves(F16 x) { return {x.a + x.b, x.a + x.b}; }
VITRINE_INLINE F16 sum_rows(F16 a, F16 b, F16 c, F16 d) {
  const __m256 sa = a.a + a.b, sb = b.a + b.b, sc = c.a + c.b, sd = d.a + d.b;
  return {_mm256_permute2f128_ps(sa, sb, 0x20) + _mm256_permute2f128_ps(sa, sb, 0x31),
          _mm256_permute2f128_ps(sc, sd, 0x20) + _mm256_permute2f128_ps(sc, sd, 0x31)};
}
VITRINE_INLINE void transpose_quarters(F16 a, F16 b, F16 c, F16 d, F16 out[4]) {
  out[0] = F16(_mm256_permute2f128_ps(a.a, b.a, 0x20), _mm256_permute2f128_ps(c.a, d.a, 0x20));
  out[1] = F16(_mm256_permute2f128_ps(a.a, b.a, 0x31), _mm256_permute2f128_ps(c.a, d.a, 0x31));
  out[2] = F16(_mm256_permute2f128_ps(a.b, b.b, 0x20), _mm256_permute2f128_ps(c.b, d.b, 0x20));
  out[3] = F16(_mm256_permute2f128_ps(a.b, b.b, 0x31), _mm256_permute2f128_ps(c.b, d.b, 0x31));
}
VITRINE_INLINE F16 from_quarters(__m128 a, __m128 b, __m128 c, __m128 d) {
  return {_mm256_set_m128(b, a), _mm256_set_m128(d, c)};
}

}  // namespace vitrine::avx2
