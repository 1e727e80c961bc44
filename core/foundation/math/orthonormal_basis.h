// Orthonormal basis of a unit vector n: unit vectors u, v with u x v = n.
//
// u = a x n, normalised, with the coordinate axis a of index `axis` (0 = x, 1 = y, 2 = z), or the next axis cyclically if n is
// within 26 degrees of a. Without `axis` u is horizontal, unless n is almost vertical.
#pragma once

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
struct OrthonormalBasis {
  Vec3<T> u, v;
};

template <class T>
OrthonormalBasis<T> orthonormal_basis(const Vec3<T>& n, size_t axis = 2) {
  using std::abs;
  Vec3<T> a{};
  a[abs(n[axis]) < T(0.9) ? axis : (axis + 1) % 3] = T(1);
  const Vec3<T> u = normalized(cross(a, n));
  return {u, cross(n, u)};
}

}  // namespace vitrine
