// Operations with different implementations for scalars and SIMD vectors. A SIMD type provides its own overloads (found by
// ADL): select(mask, a, b), gaussian(rho), reciprocal(x).
#pragma once

#include <cmath>

// The per-fragment kernels return structs of SIMD registers: without inlining they would pass through memory.
#define VITRINE_INLINE inline __attribute__((always_inline))

namespace vitrine {

template <class T>
T select(bool condition, const T& a, const T& b) {
  return condition ? a : b;
}
// exp(-rho/2)
template <class T>
T gaussian(const T& rho) {
  using std::exp;
  return exp(T(-0.5) * rho);
}
template <class T>
T reciprocal(const T& x) {
  return T(1) / x;
}

}  // namespace vitrine
