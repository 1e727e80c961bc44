// Snell's law (algorithms 5.2). d and n unit, n against d (dot(n, d) < 0), eta = index in front / index behind:
//   w = eta d + (eta cos_i - sqrt(1 - eta^2 (1 - cos_i^2))) n      cos_i = -dot(n, d)
#pragma once

#include "core/foundation/math/vec.h"

namespace vitrine {

// False at total reflection; `w` is then unchanged.
template <class T>
bool refract(const Vec3<T>& d, const Vec3<T>& n, T eta, Vec3<T>& w) {
  using std::sqrt;
  const T cosine = -dot(n, d), left = T(1) - eta * eta * (T(1) - cosine * cosine);
  if (!(left > T(0))) return false;
  w = eta * d + (eta * cosine - sqrt(left)) * n;
  return true;
}

// Unpolarised Fresnel reflectance, `cosine` = cos_i > 0; 1 at total reflection.
template <class T>
T dielectric_reflectance(T cosine, T eta) {
  using std::sqrt;
  const T left = T(1) - eta * eta * (T(1) - cosine * cosine);
  if (!(left > T(0))) return T(1);
  const T bent = sqrt(left), s = (eta * cosine - bent) / (eta * cosine + bent), p = (cosine - eta * bent) / (cosine + eta * bent);
  return (s * s + p * p) / T(2);
}

}  // namespace vitrine
