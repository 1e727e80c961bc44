// A homogeneous medium (water, haze) between the camera and the surface (algorithms 5.11; Akkaynak and Treibitz 2018):
//   I = D J + B (1 - a S)      D = exp(-b_D z), S = exp(-b_B z), per channel
// J: radiance without the medium, premultiplied by the coverage a of the pixel; z: distance along the ray. With a = 1 this is
// the published formula; where a pixel shows no surface (a = 0) the ray ends in the medium, I = B.
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"

namespace vitrine {

template <class T>
struct MediumCoefficients {
  Vec3<T> direct{}, backscatter{};  // b_D, b_B, per scene unit, >= 0
  Vec3<T> veil{};                   // B, linear radiance of the medium at infinite distance, before the view's gain
};

template <class T>
T medium_transmittance(const T& coefficient, const T& distance) {
  using std::exp;
  return exp(-(coefficient * distance));
}

// One channel. `clear`: J.
template <class T>
T seen_through_medium(const T& clear, const T& distance, const T& coverage, const T& direct, const T& backscatter,
                      const T& veil) {
  return medium_transmittance(direct, distance) * clear + veil * (T(1) - coverage * medium_transmittance(backscatter, distance));
}

template <class T>
struct MediumGradient {
  T clear{}, distance{}, coverage{}, direct{}, backscatter{}, veil{};
};

// Gradients of one channel for the gradient `g` of its I.
template <class T>
MediumGradient<T> seen_through_medium_vjp(const T& clear, const T& distance, const T& coverage, const T& direct,
                                          const T& backscatter, const T& veil, const T& g) {
  const T d = medium_transmittance(direct, distance), s = medium_transmittance(backscatter, distance);
  const T lost = g * d * clear, gained = g * veil * coverage * s;
  return {.clear = g * d,
          .distance = backscatter * gained - direct * lost,
          .coverage = -(g * veil * s),
          .direct = -(distance * lost),
          .backscatter = distance * gained,
          .veil = g * (T(1) - coverage * s)};
}

// J of an opaque surface (a = 1) from I, at least 0. Where less than 5 % of its light arrives, J is a lower bound.
template <class T>
Vec3<T> without_medium(const MediumCoefficients<T>& m, const Vec3<T>& seen, const T& distance) {
  Vec3<T> out;
  for (size_t c = 0; c < 3; ++c) {
    const T veiled = m.veil[c] * (T(1) - medium_transmittance(m.backscatter[c], distance));
    const T arrives = medium_transmittance(m.direct[c], distance);
    const T clear = (seen[c] - veiled) / (arrives > T(0.05) ? arrives : T(0.05));
    out[c] = clear > T(0) ? clear : T(0);
  }
  return out;
}

}  // namespace vitrine
