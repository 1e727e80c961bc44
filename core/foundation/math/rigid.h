// Rotations, rigid transforms and similarities. Names read b_from_a: cam_from_world * point_in_world is the point in the camera
// frame; chains read right to left. Quaternions are Hamilton, members w x y z.
#pragma once

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
struct Quat {
  T w{1}, x{}, y{}, z{};
  bool operator==(const Quat&) const = default;
};
using Quatf = Quat<float>;
using Quatd = Quat<double>;

template <class T>
VITRINE_HD Quat<T> normalized(const Quat<T>& q) {
  using std::sqrt;
  const T n = sqrt(q.w * q.w + q.x * q.x + q.y * q.y + q.z * q.z);
  return {q.w / n, q.x / n, q.y / n, q.z / n};
}

// Rotation matrix of a unit quaternion; for surfels R = [r0 r1 n] (algorithms 1.1).
template <class T>
VITRINE_HD Mat3<T> rotation_matrix(const Quat<T>& q) {
  const T w = q.w, x = q.x, y = q.y, z = q.z, one(1), two(2);
  return {{one - two * (y * y + z * z), two * (x * y + w * z), two * (x * z - w * y)},
          {two * (x * y - w * z), one - two * (x * x + z * z), two * (y * z + w * x)},
          {two * (x * z + w * y), two * (y * z - w * x), one - two * (x * x + y * y)}};
}

// Gradient of rotation_matrix(normalized(raw)) on the raw, not necessarily unit, quaternion. G = dL/dR (algorithms 1.7).
template <class T>
VITRINE_HD Quat<T> rotation_matrix_vjp(const Quat<T>& raw, const Mat3<T>& G) {
  using std::sqrt;
  const T norm = sqrt(raw.w * raw.w + raw.x * raw.x + raw.y * raw.y + raw.z * raw.z);
  const T w = raw.w / norm, x = raw.x / norm, y = raw.y / norm, z = raw.z / norm, two(2);
  const Quat<T> g{
      two * (x * (G(2, 1) - G(1, 2)) + y * (G(0, 2) - G(2, 0)) + z * (G(1, 0) - G(0, 1))),
      two * (w * (G(2, 1) - G(1, 2)) - two * x * (G(1, 1) + G(2, 2)) + y * (G(0, 1) + G(1, 0)) + z * (G(0, 2) + G(2, 0))),
      two * (w * (G(0, 2) - G(2, 0)) + x * (G(0, 1) + G(1, 0)) - two * y * (G(0, 0) + G(2, 2)) + z * (G(1, 2) + G(2, 1))),
      two * (w * (G(1, 0) - G(0, 1)) + x * (G(0, 2) + G(2, 0)) + y * (G(1, 2) + G(2, 1)) - two * z * (G(0, 0) + G(1, 1)))};
  const T along = g.w * w + g.x * x + g.y * y + g.z * z;
  return {(g.w - along * w) / norm, (g.x - along * x) / norm, (g.y - along * y) / norm, (g.z - along * z) / norm};
}

// Unit quaternion of a rotation matrix (Shepperd 1978: computes the largest component first).
template <class T>
Quat<T> quaternion(const Mat3<T>& R) {
  using std::sqrt;
  const T trace = R(0, 0) + R(1, 1) + R(2, 2);
  Quat<T> q;
  if (trace > T(0)) {
    const T s = sqrt(trace + T(1)) * T(2);
    q = {s / T(4), (R(2, 1) - R(1, 2)) / s, (R(0, 2) - R(2, 0)) / s, (R(1, 0) - R(0, 1)) / s};
  } else if (R(0, 0) > R(1, 1) && R(0, 0) > R(2, 2)) {
    const T s = sqrt(T(1) + R(0, 0) - R(1, 1) - R(2, 2)) * T(2);
    q = {(R(2, 1) - R(1, 2)) / s, s / T(4), (R(0, 1) + R(1, 0)) / s, (R(0, 2) + R(2, 0)) / s};
  } else if (R(1, 1) > R(2, 2)) {
    const T s = sqrt(T(1) + R(1, 1) - R(0, 0) - R(2, 2)) * T(2);
    q = {(R(0, 2) - R(2, 0)) / s, (R(0, 1) + R(1, 0)) / s, s / T(4), (R(1, 2) + R(2, 1)) / s};
  } else {
    const T s = sqrt(T(1) + R(2, 2) - R(0, 0) - R(1, 1)) * T(2);
    q = {(R(1, 0) - R(0, 1)) / s, (R(0, 2) + R(2, 0)) / s, (R(1, 2) + R(2, 1)) / s, s / T(4)};
  }
  return normalized(q);
}

// x -> rotation x + translation.
struct Rigid {
  Mat3d rotation = Mat3d::identity();
  Vec3d translation{};
  Vec3d operator*(const Vec3d& p) const { return rotation * p + translation; }
};
inline Rigid operator*(const Rigid& c_from_b, const Rigid& b_from_a) {
  return {c_from_b.rotation * b_from_a.rotation, c_from_b * b_from_a.translation};
}
inline Rigid inverse(const Rigid& b_from_a) {
  const Mat3d rt = transposed(b_from_a.rotation);
  return {rt, -(rt * b_from_a.translation)};
}

// x -> scale * rotation x + translation.
struct Similarity {
  double scale = 1;
  Mat3d rotation = Mat3d::identity();
  Vec3d translation{};
  Vec3d operator*(const Vec3d& p) const { return scale * (rotation * p) + translation; }
};
inline Similarity inverse(const Similarity& b_from_a) {
  const Mat3d rt = transposed(b_from_a.rotation);
  return {1 / b_from_a.scale, rt, (-1 / b_from_a.scale) * (rt * b_from_a.translation)};
}
// Camera pose after the world was transformed by `new_from_old`; camera-frame distances are scaled too.
inline Rigid transformed_world(const Rigid& cam_from_old, const Similarity& new_from_old) {
  const Mat3d rotation = cam_from_old.rotation * transposed(new_from_old.rotation);
  return {rotation, new_from_old.scale * cam_from_old.translation - rotation * new_from_old.translation};
}

struct Bounds3 {
  Vec3d low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  void extend(const Vec3d& p) {
    for (size_t i = 0; i < 3; ++i) {
      if (p[i] < low[i]) low[i] = p[i];
      if (p[i] > high[i]) high[i] = p[i];
    }
  }
  bool empty() const { return low.x > high.x; }
  template <class V>
  bool contains(const V& p) const {
    for (size_t i = 0; i < 3; ++i)
      if (!(p[i] >= low[i] && p[i] <= high[i])) return false;
    return true;
  }
  Vec3d centre() const { return 0.5 * (low + high); }
  double diagonal() const { return empty() ? 0 : length(high - low); }
};

}  // namespace vitrine
