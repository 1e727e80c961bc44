// Structural similarity of one pixel from windowed moments, and its partial derivatives (Wang et al. 2004; algorithms 5.4):
//   A1 = 2 mu_x mu_y + C1   A2 = 2 (E[xy] - mu_x mu_y) + C2   B1 = mu_x^2 + mu_y^2 + C1   B2 = var_x + var_y + C2
//   S = A1 A2 / (B1 B2)
// The moments mu_x, E[x^2], E[xy] are linear in the window, so the gradient of an image is the blurred partial derivatives.
#pragma once

#include "core/foundation/math/vec.h"

namespace vitrine {

inline constexpr int kSsimRadius = 5;  // 11x11 window
inline constexpr double kSsimSigma = 1.5;
inline constexpr float kSsimC1 = 0.01f * 0.01f, kSsimC2 = 0.03f * 0.03f;

template <class T>
struct SsimMoments {
  T mu_x, mu_y, xx, yy, xy;
};
template <class T>
struct SsimPoint {
  T value, grad_mu_x, grad_xx, grad_xy;  // x is the prediction; the photo needs no gradient
};

template <class T>
VITRINE_HD SsimPoint<T> ssim_point(const SsimMoments<T>& m) {
  const T c1 = T{} + kSsimC1, c2 = T{} + kSsimC2;
  const T mu_xy = m.mu_x * m.mu_y, mu_xx = m.mu_x * m.mu_x, mu_yy = m.mu_y * m.mu_y;
  const T a1 = mu_xy + mu_xy + c1, a2 = (m.xy - mu_xy) + (m.xy - mu_xy) + c2;
  const T b1 = mu_xx + mu_yy + c1, b2 = (m.xx - mu_xx) + (m.yy - mu_yy) + c2;
  const T ib1 = (T{} + 1.f) / b1, ib2 = (T{} + 1.f) / b2, ib = ib1 * ib2, s = a1 * a2 * ib;
  const T half_mu = m.mu_y * (a2 - a1) * ib + m.mu_x * s * (ib2 - ib1);
  return {s, half_mu + half_mu, -(s * ib2), (a1 + a1) * ib};
}

}  // namespace vitrine
