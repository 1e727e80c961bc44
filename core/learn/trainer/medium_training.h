// Gradient descent of the nine numbers of a medium (core/render/model/kernels/medium.h): Adam (Kingma and Ba 2015) on their
// logarithms, so that they stay positive. A weak pull towards the start holds numbers that the photos do not determine: b_B and B
// where all distances are short.
#pragma once

#include <array>

#include "core/learn/optim/archive.h"
#include "core/render/model/kernels/medium.h"

namespace vitrine {

enum class MediumKind : unsigned char {
  Water,  // nine numbers
  Haze    // b_D = b_B, the same in all channels; B
};

class MediumTraining {
 public:
  MediumTraining() = default;
  // All coefficients > 0.
  MediumTraining(MediumKind kind, const MediumCoefficients<double>& start);

  const MediumCoefficients<double>& coefficients() const { return now_; }
  // `gradient`: of the coefficients; skipped if not finite. `rate`: largest step of a logarithm.
  void descend(const MediumCoefficients<double>& gradient, double rate);
  void transfer(Archive& archive);

 private:
  static constexpr size_t kNumbers = 9;
  using Numbers = std::array<double, kNumbers>;  // b_D, b_B, B; of haze the first stands for all b

  MediumKind kind_ = MediumKind::Water;
  MediumCoefficients<double> now_;
  Numbers start_{}, log_{}, first_{}, second_{};
  uint64_t steps_ = 0;
};

}  // namespace vitrine
