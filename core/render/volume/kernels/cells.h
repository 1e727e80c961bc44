// Emission and absorption of a cell of a ray, front to back, with the reverse. A cell is a stretch of the ray whose optical
// depth a and emission e (sum of colour times optical depth) are known exactly; within it, colour is taken as the mean e / a:
//   light += T (1 - exp(-a)) / a e,   T *= exp(-a).
// Exact for any cells where the colour is one, and for all colours as cells become short: the error is of second order.
#pragma once

#include <bit>
#include <cstdint>

#include "core/render/volume/kernels/profile.h"

namespace vitrine {

// `series` below an optical depth of 0.3, where Taylor series are exact to rounding of double, else `direct`; of floats by bits,
// which no floating-point trap keeps from being a vector.
template <class T>
T by_depth(const T& a, const T& series, const T& direct) {
  return a < T(0.3) ? series : direct;
}
inline float by_depth(float a, float series, float direct) {
  const int32_t is_small = -int32_t(std::bit_cast<int32_t>(a) < std::bit_cast<int32_t>(0.3f));
  return std::bit_cast<float>((std::bit_cast<int32_t>(series) & is_small) | (std::bit_cast<int32_t>(direct) & ~is_small));
}

// (1 - exp(-a)) / a and its derivative, a >= 0, `e` = exp(-a).
template <class T>
T cell_share(const T& a, const T& e) {
  T series(1. / 39916800);
  series = series * a + T(-1. / 3628800);
  series = series * a + T(1. / 362880);
  series = series * a + T(-1. / 40320);
  series = series * a + T(1. / 5040);
  series = series * a + T(-1. / 720);
  series = series * a + T(1. / 120);
  series = series * a + T(-1. / 24);
  series = series * a + T(1. / 6);
  series = series * a + T(-0.5);
  series = series * a + T(1.);
  return by_depth(a, series, (T(1) - e) / by_depth(a, T(1), a));
}
template <class T>
T cell_share_slope(const T& a, const T& e) {
  T series(10. / 39916800);
  series = series * a + T(-9. / 3628800);
  series = series * a + T(8. / 362880);
  series = series * a + T(-7. / 40320);
  series = series * a + T(6. / 5040);
  series = series * a + T(-5. / 720);
  series = series * a + T(4. / 120);
  series = series * a + T(-3. / 24);
  series = series * a + T(2. / 6);
  series = series * a + T(-0.5);
  const T divisor = by_depth(a, T(1), a);
  return by_depth(a, series, (e - (T(1) - e) / divisor) / divisor);
}

template <class T>
struct RayCell {
  T depth{};
  Vec3<T> emission{};
};

// `e` = exp(-cell.depth).
template <class T>
void add_cell(const RayCell<T>& cell, const T& e, VolumeLight<T>& light) {
  light.color += (light.transmittance * cell_share(cell.depth, e)) * cell.emission;
  light.transmittance = light.transmittance * e;
}

// Back to front: `before` is the transmittance before the cell, `g` the gradient of the light's colour and `behind` the
// derivative of the loss by the logarithm of the transmittance behind the cell; at the end of the ray this is the gradient of
// the transmittance times the transmittance.
template <class T>
RayCell<T> add_cell_vjp(const RayCell<T>& cell, const T& e, const T& before, const Vec3<T>& g, T& behind) {
  const T share = before * cell_share(cell.depth, e), by_color = dot(g, cell.emission);
  const RayCell<T> out{before * cell_share_slope(cell.depth, e) * by_color - behind, share * g};
  behind = behind + share * by_color;
  return out;
}

}  // namespace vitrine
