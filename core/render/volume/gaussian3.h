// A 3D Gaussian of density, f(x) = rho exp(-|W (x - mean)|^2 / 2), rho = exp(log_density) in 1/length, with the whitening matrix
// W = diag(exp(-log_scale)) R^T: f in the frame where its covariance is the identity. All eleven values are unconstrained; a
// sum of Gaussians is a density field, positive everywhere. Frames: core/conventions.md.
#pragma once

#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "core/foundation/math/rigid.h"

namespace vitrine {

template <class T>
struct Gaussian3 {
  static constexpr size_t kValues = 11;
  Vec3<T> mean{};       // scene units
  Vec3<T> log_scale{};  // of the standard deviations along the axes, scene units
  Quat<T> rotation{};   // not necessarily unit; R = [axis 0, axis 1, axis 2]
  T log_density{};      // of the value at the mean, 1 / scene unit
  bool operator==(const Gaussian3&) const = default;
};
using Gaussian3f = Gaussian3<float>;
using Gaussian3d = Gaussian3<double>;
// Gradients by the values of a Gaussian, in the order of its members.
using Gaussian3Gradient = std::array<float, Gaussian3f::kValues>;

// In the order of the members.
template <class T>
std::array<T, Gaussian3<T>::kValues> values_of(const Gaussian3<T>& g) {
  return std::bit_cast<std::array<T, Gaussian3<T>::kValues>>(g);
}
template <class T>
Gaussian3<T> gaussian3(const std::array<T, Gaussian3<T>::kValues>& values) {
  return std::bit_cast<Gaussian3<T>>(values);
}

template <class To, class From>
Gaussian3<To> cast(const Gaussian3<From>& g) {
  return {cast<To>(g.mean),
          cast<To>(g.log_scale),
          {To(g.rotation.w), To(g.rotation.x), To(g.rotation.y), To(g.rotation.z)},
          To(g.log_density)};
}

template <class T>
struct Whitened {
  Mat3<T> matrix;  // W
  T density;       // rho
};

template <class T>
Whitened<T> whitened(const Gaussian3<T>& g) {
  using std::exp;
  const Mat3<T> r = rotation_matrix(normalized(g.rotation));
  const Vec3<T> inverse{exp(-g.log_scale.x), exp(-g.log_scale.y), exp(-g.log_scale.z)};
  const Mat3<T> rt = transposed(r);
  return {{hadamard(inverse, rt.c0), hadamard(inverse, rt.c1), hadamard(inverse, rt.c2)}, exp(g.log_density)};
}

// Gradients by the values that lines and points share: thirteen sums per Gaussian, whatever the number of rays.
template <class T>
struct WhitenedGradient {
  Vec3<T> offset{};  // of a shift of the whitened frame
  Mat3<T> matrix{};  // of W
  T log_density{};
};

// From W back to the values: dm = -W^T offset, dl_k = -sum_j G_kj W_kj, dR_jk = exp(-l_k) G_kj.
template <class T>
Gaussian3<T> whitened_vjp(const Gaussian3<T>& g, const Whitened<T>& w, const WhitenedGradient<T>& grad) {
  using std::exp;
  Gaussian3<T> out;
  out.mean = -transposed_times(w.matrix, grad.offset);
  Mat3<T> rotation;
  for (size_t k = 0; k < 3; ++k) {
    const T inverse = exp(-g.log_scale[k]);
    T along(0);
    for (size_t j = 0; j < 3; ++j) {
      along = along + grad.matrix(k, j) * w.matrix(k, j);
      rotation(j, k) = inverse * grad.matrix(k, j);
    }
    out.log_scale[k] = -along;
  }
  out.rotation = rotation_matrix_vjp(g.rotation, rotation);
  out.log_density = grad.log_density;
  return out;
}

}  // namespace vitrine
