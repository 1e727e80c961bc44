// Front-to-back blending along one pixel, and its reverse (README 5). A fragment i with alpha_i and the transmittance T_i in
// front of it has weight w_i = alpha_i T_i if T_i >= kMinTransmittance, otherwise 0. Every output is a sum over w_i:
//   feature = sum w f (+ (1 - sum w) background)    zdepth = sum w z    alpha = sum w
//   distortion = sum_{i<j} w_i w_j (m_i - m_j)^2 = k^2 (A Q2 - Q1^2),  Q1 = sum w q, Q2 = sum w q^2, q = 1/z - pivot
//   median_z = largest z with T > 1/2
// (Porter and Duff 1984; distortion: Barron et al. 2022, Huang et al. 2024; algorithms 1.6, 1.7),
// with m = far/(far-near) (1 - near/z), hence m_i - m_j = -k (q_i - q_j), k = far near/(far-near). The value does not depend on
// the pivot; a pivot close to 1/z preserves precision. Only T depends on the order of summation.
#pragma once

#include "core/render/raster/kernels/scalar_ops.h"

namespace vitrine {

template <class T>
VITRINE_INLINE T blend_weight(const T& alpha, const T& transmittance) {
  return select(transmittance >= T(kMinTransmittance), alpha * transmittance, T(0));
}

// k as defined above.
template <class T>
VITRINE_HD T distortion_scale(const T& near_z, const T& far_z) {
  return far_z * near_z / (far_z - near_z);
}

template <class T>
struct DistortionSums {
  T a{}, q1{}, q2{};  // sum w, sum w q, sum w q^2
  VITRINE_HD void add(const T& w, const T& q) {
    a += w;
    q1 += w * q;
    q2 += w * q * q;
  }
  // d distortion / d w of a fragment at q, and d distortion / d z through q = 1/z - pivot, for k = 1.
  VITRINE_HD T value() const { return a * q2 - q1 * q1; }
  VITRINE_HD T weight_slope(const T& q) const { return q2 + q * (q * a - T(2) * q1); }
  VITRINE_HD T depth_slope(const T& w, const T& q, const T& inv_z) const { return T(-2) * w * (q * a - q1) * inv_z * inv_z; }
};

// L = sum_j w_j V_j with w_j = alpha_j prod_{front}(1 - alpha): dL/d alpha_i = T_i V_i - (sum_{j behind i} w_j V_j)/(1 -
// alpha_i), zero for fragments that were not blended.
template <class T>
VITRINE_INLINE T blend_vjp(const T& transmittance, const T& value, const T& behind, const T& inv_transparency) {
  return select(transmittance >= T(kMinTransmittance), transmittance * value - behind * inv_transparency, T(0));
}

}  // namespace vitrine
