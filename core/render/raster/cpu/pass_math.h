// Transcendental functions of the pass's SIMD type. Included by pass_avx2.cpp and pass_avx512.cpp with VITRINE_SIMD set.
// Polynomials interpolate at Chebyshev nodes; relative error of 2^x 8e-8, absolute error of ln 1.2e-5 (only used by cuts).

namespace vitrine::VITRINE_SIMD {

VITRINE_INLINE F16 exp2_below_126(F16 x) {
  x = max(x, F16(-126.f));
  const F16 whole = round_nearest(x), f = x - whole;
  F16 p(1.33908634e-3f);
  p = p * f + F16(9.67603192e-3f);
  p = p * f + F16(5.55035711e-2f);
  p = p * f + F16(2.40221075e-1f);
  p = p * f + F16(6.93147188e-1f);
  p = p * f + F16(1.00000008f);
  return scale_by_power(p, whole);
}
inline constexpr float kLog2E = 1.44269504f;
VITRINE_INLINE F16 exp(F16 x) { return exp2_below_126(min(x * F16(kLog2E), F16(126.f))); }
VITRINE_INLINE F16 gaussian(F16 rho) { return exp2_below_126(rho * F16(-0.5f * kLog2E)); }
// Natural logarithm of positive normal values.
VITRINE_INLINE F16 log_of(F16 x) {
  const F16 m = mantissa(x) - F16(1.5f);
  F16 p(2.98087652e-2f);
  p = p * m + F16(-5.54352845e-2f);
  p = p * m + F16(9.84307009e-2f);
  p = p * m + F16(-2.21639156e-1f);
  p = p * m + F16(6.66671338e-1f);
  p = p * m + F16(4.05456972e-1f);
  return p + exponent(x) * F16(0.693147181f);
}
VITRINE_INLINE F16 clamp(F16 x, F16 low, F16 high) { return min(max(x, low), high); }

}  // namespace vitrine::VITRINE_SIMD
