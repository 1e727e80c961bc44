// Terms of the losses with targets, one pixel (algorithms 5.4): specular_mask.cpp, mask_cross_entropy.cpp, monocular_normal.cpp,
// and the same as kernels for a GPU (blocks/target_loss_kernels.h).
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"

namespace vitrine {

// A term by the value of a channel, and its derivative.
template <class T>
struct ChannelTerm {
  T value, slope;
};

// (1 - M) K + b M max(0, K0 - K), K the blended specular weight, M the mask.
template <class T>
VITRINE_HD ChannelTerm<T> specular_mask_term(const T& weight, const T& mask) {
  constexpr float kInsideShare = 0.5f;   // b: weight of the pixels inside the mask relative to those outside
  constexpr float kInsideTarget = 0.3f;  // K0: specular weight that a pixel inside the mask should reach
  const T room = T(kInsideTarget) - weight, missing = T(0) < room ? room : T(0);
  const T slope = T(1) - mask - (missing > T(0) ? T(kInsideShare) * mask : T(0));
  return {(T(1) - mask) * weight + T(kInsideShare) * mask * missing, slope};
}

// -M log q - (1 - M) log(1 - q), extrapolated linearly outside [e, 1 - e].
template <class T>
VITRINE_HD ChannelTerm<T> cross_entropy_term(const T& q, const T& mask) {
  using std::log;
  constexpr float kEnd = 0.01f;
  const T inner = q < T(kEnd) ? T(kEnd) : T(1 - kEnd) < q ? T(1 - kEnd) : q;
  const T slope = (inner - mask) / (inner * (T(1) - inner));
  return {-mask * log(inner) - (T(1) - mask) * log(T(1) - inner) + slope * (q - inner), slope};
}

// Pixels have no usable normal below this alpha, if the length of the blended normal is below this (opposite ones cancel), or if
// the target has a smaller squared length: 0, unknown.
struct UsableNormal {
  static constexpr float kLeastAlpha = 0.3f, kShortest = 0.05f, kShortestTarget = 0.25f;
};

// |n - n_t|_1 + 1 - n . n_t of unit vectors, and the part of its gradient by n that is perpendicular to n.
template <class T>
struct TargetNormalTerm {
  T value;
  Vec3<T> tangent;
};
template <class T>
VITRINE_HD TargetNormalTerm<T> target_normal_term(const Vec3<T>& n, const Vec3<T>& target) {
  Vec3<T> g = -target;
  T value = T(1) - dot(n, target);
  for (size_t c = 0; c < 3; ++c) {
    const T off = n[c] - target[c];
    value += off < T(0) ? -off : off;
    if (off != T(0)) g[c] += off < T(0) ? T(-1) : T(1);
  }
  return {value, g - dot(n, g) * n};
}

}  // namespace vitrine
