// SIMD type of sixteen floats in one AVX-512 register, with the operations of the kernels. Multiplications and additions are
// plain operators, so that the compiler contracts them (-ffp-contract=fast) into fused ones.
#pragma once

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine::avx512 {

struct M16 {
  __mmask16 m;
  friend M16 operator&(M16 a, M16 b) { return {static_cast<__mmask16>(a.m & b.m)}; }
  friend M16 operator|(M16 a, M16 b) { return {static_cast<__mmask16>(a.m | b.m)}; }
  M16 operator~() const { return {static_cast<__mmask16>(~m)}; }
};
VITRINE_INLINE bool any(M16 a) { return a.m != 0; }
VITRINE_INLINE uint32_t bits(M16 a) { return a.m; }
VITRINE_INLINE M16 mask_from_bits(uint32_t b) { return {static_cast<__mmask16>(b)}; }

struct F16 {
  __m512 v;
  F16() : v(_mm512_setzero_ps()) {}
  F16(__m512 a) : v(a) {}                 // NOLINT
  F16(float a) : v(_mm512_set1_ps(a)) {}  // NOLINT: implicit broadcast of constants is intended
  friend F16 operator+(F16 a, F16 b) { return _mm512_add_ps(a.v, b.v); }
  friend F16 operator-(F16 a, F16 b) { return _mm512_sub_ps(a.v, b.v); }
  friend F16 operator*(F16 a, F16 b) { return _mm512_mul_ps(a.v, b.v); }
  friend F16 operator/(F16 a, F16 b) { return _mm512_div_ps(a.v, b.v); }
  F16 operator-() const { return _mm512_sub_ps(_mm512_setzero_ps(), v); }
  F16& operator+=(F16 b) { return *this = *this + b; }
  F16& operator-=(F16 b) { return *this = *this - b; }
  F16& operator*=(F16 b) { return *this = *this * b; }
  friend M16 operator<(F16 a, F16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LT_OQ)}; }
  friend M16 operator>(F16 a, F16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_GT_OQ)}; }
  friend M16 operator<=(F16 a, F16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_LE_OQ)}; }
  friend M16 operator>=(F16 a, F16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_GE_OQ)}; }
  friend M16 operator==(F16 a, F16 b) { return {_mm512_cmp_ps_mask(a.v, b.v, _CMP_EQ_OQ)}; }
};
VITRINE_INLINE F16 load(const float* p) { return _mm512_load_ps(p); }
VITRINE_INLINE void store(float* p, F16 a) { _mm512_store_ps(p, a.v); }
// Four rows of four floats, `stride` apart.
VITRINE_INLINE void store_rows(float* p, size_t stride, F16 a) {
  _mm_storeu_ps(p, _mm512_castps512_ps128(a.v));
  _mm_storeu_ps(p + stride, _mm512_extractf32x4_ps(a.v, 1));
  _mm_storeu_ps(p + 2 * stride, _mm512_extractf32x4_ps(a.v, 2));
  _mm_storeu_ps(p + 3 * stride, _mm512_extractf32x4_ps(a.v, 3));
}
// Mask of the first `count` of sixteen floats; the others are not accessed, and read as zero.
VITRINE_INLINE __mmask16 first_lanes(uint32_t count) { return static_cast<__mmask16>((1u << count) - 1u); }
VITRINE_INLINE F16 load_first(const float* p, uint32_t count) { return _mm512_maskz_loadu_ps(first_lanes(count), p); }
VITRINE_INLINE void store_first(float* p, uint32_t count, F16 a) { _mm512_mask_storeu_ps(p, first_lanes(count), a.v); }
VITRINE_INLINE F16 iota() { return _mm512_setr_ps(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15); }
VITRINE_INLINE F16 select(M16 m, F16 a, F16 b) { return _mm512_mask_blend_ps(m.m, b.v, a.v); }
// a + b where m holds, a elsewhere; and a b; and a (1 - b). One instruction each.
VITRINE_INLINE F16 add_where(M16 m, F16 a, F16 b) { return _mm512_mask_add_ps(a.v, m.m, a.v, b.v); }
VITRINE_INLINE F16 multiply_where(M16 m, F16 a, F16 b) { return _mm512_mask_mul_ps(a.v, m.m, a.v, b.v); }
VITRINE_INLINE F16 dim_where(M16 m, F16 a, F16 b) { return _mm512_mask_fnmadd_ps(a.v, m.m, b.v, a.v); }
VITRINE_INLINE F16 min(F16 a, F16 b) { return _mm512_min_ps(a.v, b.v); }
VITRINE_INLINE F16 max(F16 a, F16 b) { return _mm512_max_ps(a.v, b.v); }
VITRINE_INLINE F16 sqrt(F16 a) { return _mm512_sqrt_ps(a.v); }
// rcp14 and one Newton step: about 1 ulp.
VITRINE_INLINE F16 reciprocal(F16 a) {
  const F16 r = _mm512_rcp14_ps(a.v);
  return r * (F16(2.f) - a * r);
}
VITRINE_INLINE F16 next_above(F16 a) {  // of positive finite values
  return _mm512_castsi512_ps(_mm512_add_epi32(_mm512_castps_si512(a.v), _mm512_set1_epi32(1)));
}
VITRINE_INLINE F16 round_nearest(F16 a) { return _mm512_roundscale_ps(a.v, _MM_FROUND_TO_NEAREST_INT | _MM_FROUND_NO_EXC); }
VITRINE_INLINE F16 scale_by_power(F16 a, F16 e) { return _mm512_scalef_ps(a.v, e.v); }  // a 2^e, e integral
VITRINE_INLINE F16 exponent(F16 a) { return _mm512_getexp_ps(a.v); }
VITRINE_INLINE F16 mantissa(F16 a) { return _mm512_getmant_ps(a.v, _MM_MANT_NORM_1_2, _MM_MANT_SIGN_src); }
// Broadcasts lane 2 `pair` of `a` to the first eight lanes, and the next lane to the last eight.
VITRINE_INLINE F16 spread_pair(F16 a, int pair) {
  const __m512i half = _mm512_setr_epi32(0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1);
  return _mm512_permutexvar_ps(_mm512_add_epi32(half, _mm512_set1_epi32(2 * pair)), a.v);
}
VITRINE_INLINE F16 absolute(F16 a) { return _mm512_abs_ps(a.v); }

// A register contains four rows of four columns. Converts four registers (one quantity each) into four (one column each), rows
// kept: out[j] row r = (a, b, c, d) at row r, column j.
VITRINE_INLINE void columns_of(F16 a, F16 b, F16 c, F16 d, F16 out[4]) {
  const __m512d t0 = _mm512_castps_pd(_mm512_unpacklo_ps(a.v, b.v)), t1 = _mm512_castps_pd(_mm512_unpackhi_ps(a.v, b.v));
  const __m512d t2 = _mm512_castps_pd(_mm512_unpacklo_ps(c.v, d.v)), t3 = _mm512_castps_pd(_mm512_unpackhi_ps(c.v, d.v));
  out[0] = _mm512_castpd_ps(_mm512_unpacklo_pd(t0, t2));
  out[1] = _mm512_castpd_ps(_mm512_unpackhi_pd(t0, t2));
  out[2] = _mm512_castpd_ps(_mm512_unpacklo_pd(t1, t3));
  out[3] = _mm512_castpd_ps(_mm512_unpackhi_pd(t1, t3));
}
// Row by row: (a0 + a2, b0 + b2, a1 + a3, b1 + b3).
VITRINE_INLINE F16 pair_columns(F16 a, F16 b) { return _mm512_unpacklo_ps(a.v, b.v) + _mm512_unpackhi_ps(a.v, b.v); }
VITRINE_INLINE F16 fold_halves(F16 a) { return a.v + _mm512_shuffle_f32x4(a.v, a.v, 0x4E); }  // a_i + a_{i +- 8}
// Row k of the result is the sum over the rows of argument k.
VITRINE_INLINE F16 sum_rows(F16 a, F16 b, F16 c, F16 d) {
  const __m512 ab = _mm512_shuffle_f32x4(a.v, b.v, 0x44) + _mm512_shuffle_f32x4(a.v, b.v, 0xEE);
  const __m512 cd = _mm512_shuffle_f32x4(c.v, d.v, 0x44) + _mm512_shuffle_f32x4(c.v, d.v, 0xEE);
  return _mm512_shuffle_f32x4(ab, cd, 0x88) + _mm512_shuffle_f32x4(ab, cd, 0xDD);
}
// Quarter k of out[j] is quarter j of argument k.
VITRINE_INLINE void transpose_quarters(F16 a, F16 b, F16 c, F16 d, F16 out[4]) {
  const __m512 ab_low = _mm512_shuffle_f32x4(a.v, b.v, 0x44), ab_high = _mm512_shuffle_f32x4(a.v, b.v, 0xEE);
  const __m512 cd_low = _mm512_shuffle_f32x4(c.v, d.v, 0x44), cd_high = _mm512_shuffle_f32x4(c.v, d.v, 0xEE);
  out[0] = _mm512_shuffle_f32x4(ab_low, cd_low, 0x88);
  out[1] = _mm512_shuffle_f32x4(ab_low, cd_low, 0xDD);
  out[2] = _mm512_shuffle_f32x4(ab_high, cd_high, 0x88);
  out[3] = _mm512_shuffle_f32x4(ab_high, cd_high, 0xDD);
}
VITRINE_INLINE F16 from_quarters(__m128 a, __m128 b, __m128 c, __m128 d) {
  const __m512 ab = _mm512_insertf32x4(_mm512_castps128_ps512(a), b, 1);
  return _mm512_insertf32x4(_mm512_insertf32x4(ab, c, 2), d, 3);
}

}  // namespace vitrine::avx512
