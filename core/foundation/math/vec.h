// Small fixed-size vectors and matrices, templated on the scalar (double, float, Dual). Mat3 is column-major: R = [c0 c1 c2], R
// * v = c0 v.x + c1 v.y + c2 v.z.
#pragma once

#include <cmath>
#include <cstddef>

// Functions that CUDA kernels call, too: compiled for the host and the device by nvcc, for the host alone by other compilers.
#ifdef __CUDACC__
#define VITRINE_HD __host__ __device__
#else
#define VITRINE_HD
#endif

namespace vitrine {

template <class T> struct Vec2 {
  T x{}, y{};
  VITRINE_HD T& operator[](size_t i) { return i == 0 ? x : y; }
  VITRINE_HD const T& operator[](size_t i) const { return i == 0 ? x : y; }
};

template <class T> struct Vec3 {
  T x{}, y{}, z{};
  VITRINE_HD T& operator[](size_t i) { return i == 0 ? x : i == 1 ? y : z; }
  VITRINE_HD const T& operator[](size_t i) const { return i == 0 ? x : i == 1 ? y : z; }
  bool operator==(const Vec3&) const = default;
};

using Vec2f = Vec2<float>;
using Vec2d = Vec2<double>;
using Vec3f = Vec3<float>;
using Vec3d = Vec3<double>;

template <class T> VITRINE_HD Vec2<T> operator+(Vec2<T> a, Vec2<T> b) { return {a.x + b.x, a.y + b.y}; }
template <class T> VITRINE_HD Vec2<T> operator-(Vec2<T> a, Vec2<T> b) { return {a.x - b.x, a.y - b.y}; }
template <class T> VITRINE_HD Vec2<T> operator*(T s, Vec2<T> a) { return {s * a.x, s * a.y}; }

template <class T> VITRINE_HD Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
template <class T> VITRINE_HD Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
template <class T> VITRINE_HD Vec3<T> operator-(const Vec3<T>& a) { return {-a.x, -a.y, -a.z}; }
template <class T> VITRINE_HD Vec3<T> operator*(const T& s, const Vec3<T>& a) { return {s * a.x, s * a.y, s * a.z}; }
template <class T> VITRINE_HD Vec3<T> operator*(const Vec3<T>& a, const T& s) { return {s * a.x, s * a.y, s * a.z}; }
template <class T> VITRINE_HD Vec3<T> operator/(const Vec3<T>& a, const T& s) { return {a.x / s, a.y / s, a.z / s}; }
template <class T> VITRINE_HD Vec3<T>& operator+=(Vec3<T>& a, const Vec3<T>& b) { return a = a + b; }
template <class T> VITRINE_HD Vec3<T>& operator-=(Vec3<T>& a, const Vec3<T>& b) { return a = a - b; }
template <class T> VITRINE_HD Vec3<T>& operator*=(Vec3<T>& a, const T& s) { return a = s * a; }
template <class T> VITRINE_HD Vec3<T> hadamard(const Vec3<T>& a, const Vec3<T>& b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
template <class T> VITRINE_HD T dot(const Vec3<T>& a, const Vec3<T>& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
template <class T> VITRINE_HD Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
template <class T> VITRINE_HD T squared_length(const Vec3<T>& a) { return dot(a, a); }
template <class T> VITRINE_HD T length(const Vec3<T>& a) { using std::sqrt; return sqrt(dot(a, a)); }
template <class T> VITRINE_HD Vec3<T> normalized(const Vec3<T>& a) { return a / length(a); }
// Gradient of normalized(): grad_a = (I - n n^T) grad_n / |a|.
template <class T> VITRINE_HD Vec3<T> normalized_vjp(const Vec3<T>& a, const Vec3<T>& grad_n) {
  const T len = length(a);
  const Vec3<T> n = a / len;
  return (grad_n - dot(n, grad_n) * n) / len;
}
template <class To, class From> VITRINE_HD Vec3<To> cast(const Vec3<From>& a) {
  return {static_cast<To>(a.x), static_cast<To>(a.y), static_cast<To>(a.z)};
}

template <class T> struct Mat3 {
  Vec3<T> c0{}, c1{}, c2{};                                   // columns
  VITRINE_HD Vec3<T>& column(size_t i) { return i == 0 ? c0 : i == 1 ? c1 : c2; }
  VITRINE_HD const Vec3<T>& column(size_t i) const { return i == 0 ? c0 : i == 1 ? c1 : c2; }
  VITRINE_HD const T& operator()(size_t row, size_t col) const { return column(col)[row]; }
  VITRINE_HD T& operator()(size_t row, size_t col) { return column(col)[row]; }
  VITRINE_HD static Mat3 identity() { return {{T(1), T(0), T(0)}, {T(0), T(1), T(0)}, {T(0), T(0), T(1)}}; }
  bool operator==(const Mat3&) const = default;
};
using Mat3f = Mat3<float>;
using Mat3d = Mat3<double>;

template <class T>
VITRINE_HD Vec3<T> operator*(const Mat3<T>& m, const Vec3<T>& v) { return v.x * m.c0 + v.y * m.c1 + v.z * m.c2; }
template <class T> VITRINE_HD Mat3<T> operator*(const Mat3<T>& a, const Mat3<T>& b) { return {a * b.c0, a * b.c1, a * b.c2}; }
template <class T> VITRINE_HD Mat3<T> transposed(const Mat3<T>& m) {
  return {{m.c0.x, m.c1.x, m.c2.x}, {m.c0.y, m.c1.y, m.c2.y}, {m.c0.z, m.c1.z, m.c2.z}};
}
template <class T>
VITRINE_HD Vec3<T> transposed_times(const Mat3<T>& m, const Vec3<T>& v) { return {dot(m.c0, v), dot(m.c1, v), dot(m.c2, v)}; }
template <class T> VITRINE_HD T determinant(const Mat3<T>& m) { return dot(m.c0, cross(m.c1, m.c2)); }
template <class To, class From>
VITRINE_HD Mat3<To> cast(const Mat3<From>& m) { return {cast<To>(m.c0), cast<To>(m.c1), cast<To>(m.c2)}; }

// Orthonormal basis of a unit vector n: unit vectors u, v with u x v = n.
//
// u = a x n, normalised, with the coordinate axis a of index `axis` (0 = x, 1 = y, 2 = z), or the next axis cyclically if n is
// within 26 degrees of a. Without `axis` u is horizontal, unless n is almost vertical.
template <class T>
struct OrthonormalBasis {
  Vec3<T> u, v;
};

template <class T>
VITRINE_HD OrthonormalBasis<T> orthonormal_basis(const Vec3<T>& n, size_t axis = 2) {
  using std::abs;
  Vec3<T> a{};
  a[abs(n[axis]) < T(0.9) ? axis : (axis + 1) % 3] = T(1);
  const Vec3<T> u = normalized(cross(a, n));
  return {u, cross(n, u)};
}

}  // namespace vitrine
