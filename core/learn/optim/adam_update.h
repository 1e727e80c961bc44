// The formula of Adam (Kingma and Ba 2015) for one float, shared by the CPU (adam.h) and the kernels for a GPU (blocks/):
//   m <- b1 m + (1-b1) g    v <- b2 v + (1-b2) g^2    x <- x - rate * m/(1-b1^t) / (sqrt(v/(1-b2^t)) + eps)
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

struct AdamDesc {
  double beta1 = 0.9, beta2 = 0.999;
  float epsilon = 1e-15f;  // tiny: gradients of means over an image are tiny themselves
};

// 1/(1-b1^t) and 1/sqrt(1-b2^t) by t, until both are 1: later steps have the last ones.
struct AdamCorrections {
  std::vector<float> first, second;
};
inline AdamCorrections adam_corrections(const AdamDesc& desc) {
  constexpr size_t kMostSteps = size_t{1} << 16;
  AdamCorrections c{{1.f}, {1.f}};
  for (size_t t = 1; t < kMostSteps; ++t) {
    const double power = static_cast<double>(t);
    c.first.push_back(static_cast<float>(1 / (1 - std::pow(desc.beta1, power))));
    c.second.push_back(static_cast<float>(1 / std::sqrt(1 - std::pow(desc.beta2, power))));
    if (c.first.back() == 1.f && c.second.back() == 1.f) break;
  }
  return c;
}

// Of a surfel: rate / (1-b1^t), 1/sqrt(1-b2^t), and 1, or 0 if it stays as it is.
template <class T>
struct AdamStep {
  T step, root, moves;
};

template <class T>
VITRINE_HD inline void adam_update(const T& gradient, const AdamStep<T>& s, const T& beta1, const T& beta2, const T& epsilon,
                                   T& m, T& v, T& x) {
  using std::sqrt;
  m += s.moves * (T(1) - beta1) * (gradient - m);
  v += s.moves * (T(1) - beta2) * (gradient * gradient - v);
  x -= s.step * m / (sqrt(v) * s.root + epsilon);
}

}  // namespace vitrine
