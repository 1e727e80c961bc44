// Activation functions between raw and physical values: scale = exp, opacity and materials = sigmoid, quaternion = normalise
// (row().activation).
#pragma once

#include <cmath>

#include "core/foundation/math/vec.h"
#include "core/scene/surfels/attributes.h"

namespace vitrine {

template <class T> VITRINE_HD T sigmoid(const T& x) {
  using std::exp;
  return T(1) / (T(1) + exp(-x));
}
template <class T> T logit(const T& p) {
  using std::log;
  return log(p / (T(1) - p));
}
// Raw value whose activation is `value` (Normalize and Identity: itself).
inline float raw_value(Activation activation, float value) {
  switch (activation) {
    case Activation::Exp: return std::log(value);
    case Activation::Sigmoid: return logit(value);
    case Activation::Identity:
    case Activation::Normalize: return value;
  }
  return value;
}
inline float activated_value(Activation activation, float raw) {
  switch (activation) {
    case Activation::Exp: return std::exp(raw);
    case Activation::Sigmoid: return sigmoid(raw);
    case Activation::Identity:
    case Activation::Normalize: return raw;
  }
  return raw;
}

}  // namespace vitrine
