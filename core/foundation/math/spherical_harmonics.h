// Real spherical harmonics up to degree 3 in the storage order of 3D Gaussian splatting files, for compatible PLY export. Y_0 =
// 0.28209479.
#pragma once

#include <cstddef>

#include "core/foundation/math/vec.h"

namespace vitrine {

constexpr float kShDc = 0.28209479177387814f;
VITRINE_HD constexpr size_t sh_coefficient_count(int degree) { return static_cast<size_t>((degree + 1) * (degree + 1)); }

// Fills basis[k] for k < sh_coefficient_count(degree); `dir` is a unit vector.
template <class T> VITRINE_HD void sh_basis(int degree, const Vec3<T>& dir, T* basis) {
  const T x = dir.x, y = dir.y, z = dir.z;
  basis[0] = T(kShDc);
  if (degree < 1) return;
  const T c1(0.4886025119029199f);
  basis[1] = -c1 * y;
  basis[2] = c1 * z;
  basis[3] = -c1 * x;
  if (degree < 2) return;
  const T xx = x * x, yy = y * y, zz = z * z;
  basis[4] = T(1.0925484305920792f) * x * y;
  basis[5] = T(-1.0925484305920792f) * y * z;
  basis[6] = T(0.31539156525252005f) * (T(2) * zz - xx - yy);
  basis[7] = T(-1.0925484305920792f) * x * z;
  basis[8] = T(0.5462742152960396f) * (xx - yy);
  if (degree < 3) return;
  basis[9] = T(-0.5900435899266435f) * y * (T(3) * xx - yy);
  basis[10] = T(2.890611442640554f) * x * y * z;
  basis[11] = T(-0.4570457994644658f) * y * (T(4) * zz - xx - yy);
  basis[12] = T(0.3731763325901154f) * z * (T(2) * zz - T(3) * xx - T(3) * yy);
  basis[13] = T(-0.4570457994644658f) * x * (T(4) * zz - xx - yy);
  basis[14] = T(1.445305721320277f) * z * (xx - yy);
  basis[15] = T(-0.5900435899266435f) * x * (xx - T(3) * yy);
}

// Gradient of sum_k weight[k] * basis[k] with respect to `dir` (three independent coordinates).
template <class T> VITRINE_HD Vec3<T> sh_basis_vjp(int degree, const Vec3<T>& dir, const T* weight) {
  Vec3<T> g{T(0), T(0), T(0)};
  if (degree < 1) return g;
  const T x = dir.x, y = dir.y, z = dir.z;
  const T c1(0.4886025119029199f);
  g = {-c1 * weight[3], -c1 * weight[1], c1 * weight[2]};
  if (degree < 2) return g;
  const T a(1.0925484305920792f), b(0.31539156525252005f), c(0.5462742152960396f), two(2);
  g.x += a * y * weight[4] - two * b * x * weight[6] - a * z * weight[7] + two * c * x * weight[8];
  g.y += a * x * weight[4] - a * z * weight[5] - two * b * y * weight[6] - two * c * y * weight[8];
  g.z += -a * y * weight[5] + T(4) * b * z * weight[6] - a * x * weight[7];
  if (degree < 3) return g;
  const T xx = x * x, yy = y * y, zz = z * z;
  const T k9(-0.5900435899266435f), k10(2.890611442640554f), k11(-0.4570457994644658f), k12(0.3731763325901154f),
      k14(1.445305721320277f), six(6), three(3), eight(8);
  g.x += k9 * six * x * y * weight[9] + k10 * y * z * weight[10] - two * k11 * x * y * weight[11] -
         six * k12 * x * z * weight[12] + k11 * (T(4) * zz - three * xx - yy) * weight[13] + two * k14 * x * z * weight[14] +
         k9 * three * (xx - yy) * weight[15];
  g.y += k9 * three * (xx - yy) * weight[9] + k10 * x * z * weight[10] + k11 * (T(4) * zz - xx - three * yy) * weight[11] -
         six * k12 * y * z * weight[12] - two * k11 * x * y * weight[13] - two * k14 * y * z * weight[14] -
         k9 * six * x * y * weight[15];
  g.z += k10 * x * y * weight[10] + eight * k11 * y * z * weight[11] + k12 * (six * zz - three * xx - three * yy) * weight[12] +
         eight * k11 * x * z * weight[13] + k14 * (xx - yy) * weight[14];
  return g;
}

}  // namespace vitrine
