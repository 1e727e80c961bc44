// Consistency of a blended normal N with the gradient of the rendered depth (algorithms 1.8), one pixel, camera frame:
//   q = a x b   with a, b the central differences of the unprojected depth down and right
//   value = A - N . (A q / |q|) ... per pixel:  A (1 - N . n_d) with n_d = q/|q| and A (the alpha) held constant.
#pragma once

#include "core/foundation/math/vec.h"

namespace vitrine {

inline constexpr float kLeastAlphaOfDepth = 0.3f;  // below this alpha a pixel has no usable depth

template <class T>
struct NormalTerm {
  T value;
  Vec3<T> grad_normal, grad_a, grad_b;
};

// N is unnormalised (its length is at most the alpha). Returns value 0 and no gradient where the depth gradient is undefined.
template <class T>
VITRINE_HD NormalTerm<T> normal_term(const Vec3<T>& N, const Vec3<T>& a, const Vec3<T>& b, const T& alpha) {
  using std::sqrt;
  const Vec3<T> q = cross(a, b);
  const T squared = dot(q, q);
  if (!(squared > T(1e-30f))) return {T(0), {}, {}, {}};
  const T inverse = T(1) / sqrt(squared);
  const Vec3<T> n = inverse * q;
  const T agreement = dot(N, n);
  const Vec3<T> grad_q = (-alpha * inverse) * (N - agreement * n);  // d/dq of -alpha N . q/|q|
  return {alpha * (T(1) - agreement), -alpha * n, cross(b, grad_q), cross(grad_q, a)};
}

}  // namespace vitrine
