// Mirror reflection of a view direction about a half vector, and rotation of a half vector with the normal (README 3).
//   w = 2 (v.h) h - v          v, w, h unit, v and w point away from the surface; h = n is the mirror
//   dh = (n x dn) x h          a rotating normal rotates its half vectors by the smallest rotation
#pragma once

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
Vec3<T> reflected(const Vec3<T>& v, const Vec3<T>& h) {
  return (T(2) * dot(v, h)) * h - v;
}

// Gradient of h from the gradient of the reflected direction; v is constant.
template <class T>
Vec3<T> reflected_vjp(const Vec3<T>& v, const Vec3<T>& h, const Vec3<T>& grad_w) {
  return T(2) * (dot(v, h) * grad_w + dot(grad_w, h) * v);
}

// Half vector `h`, chosen around the unit normal `from`, rotated to the normal `to` (exact for any angle below pi).
template <class T>
Vec3<T> carried(const Vec3<T>& h, const Vec3<T>& from, const Vec3<T>& to) {
  const Vec3<T> axis = cross(from, to);
  return dot(from, to) * h + cross(axis, h) + (dot(axis, h) / (T(1) + dot(from, to))) * axis;
}

// Gradient of the normal at from = to = n. For the mirror, h = n, this is the projection onto the tangent plane.
template <class T>
Vec3<T> carried_vjp(const Vec3<T>& h, const Vec3<T>& n, const Vec3<T>& grad_h) {
  return dot(n, h) * grad_h - dot(n, grad_h) * h;
}

// Two unit tangents such that (t0, t1, n) is a right-handed frame: the smallest rotation from the pole to n (Duff et al. 2017).
template <class T>
void tangents(const Vec3<T>& n, Vec3<T>& t0, Vec3<T>& t1) {
  const T pole = n.z < T(0) ? T(-1) : T(1), a = T(-1) / (pole + n.z), b = n.x * n.y * a;
  t0 = {T(1) + pole * n.x * n.x * a, pole * b, -(pole * n.x)};
  t1 = {b, pole + n.y * n.y * a, -n.y};
}

// Snell's law (algorithms 5.2). d and n unit, n against d (dot(n, d) < 0), eta = index in front / index behind:
//   w = eta d + (eta cos_i - sqrt(1 - eta^2 (1 - cos_i^2))) n      cos_i = -dot(n, d)

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
