// Mask with per-pixel weights v = 1 - ignore for losses. Sums per row, so that any number of threads gives the same bits.
#pragma once

#include "core/foundation/base/error.h"
#include "core/learn/loss/loss.h"
#include "core/learn/loss/row_sum.h"

namespace vitrine {

class TargetMask {
 public:
  TargetMask(const LossInput& input, std::span<const float> mask)
      : mask_(mask), ignore_(input.targets.ignore), width_(static_cast<size_t>(input.view->intrinsics.width)) {
    VITRINE_CHECK(mask.size() == width_ * static_cast<size_t>(input.view->intrinsics.height), "a mask of {} pixels", mask.size());
    VITRINE_CHECK(ignore_.empty() || ignore_.size() == mask.size(), "an ignore mask of {} pixels", ignore_.size());
    total_ = static_cast<double>(mask.size()) - sum_of(ignore_);
  }

  double total() const { return total_; }  // sum of v

  // Sum of body(i, mask, v) over the pixels.
  template <class Body>
  double sum_over_pixels(std::vector<double>& scratch, const Body& body) const {
    return sum_over_rows(mask_.size() / width_, scratch, [&](size_t row) {
      double sum = 0;
      for (size_t i = row * width_; i < (row + 1) * width_; ++i)
        sum += body(i, mask_[i], ignore_.empty() ? 1.f : 1.f - ignore_[i]);
      return sum;
    });
  }

 private:
  std::span<const float> mask_, ignore_;
  size_t width_;
  double total_;
};

}  // namespace vitrine
