// Mask with per-pixel weights v = 1 - ignore for losses. Sums per row, so that any number of threads gives the same bits.
#pragma once

#include <span>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/learn/loss/loss.h"

namespace vitrine {

// Deterministic sums over an image: one double per row, added in row order, so that any number of threads gives the same bits.
inline constexpr size_t kRowGrain = 8;

// Sum over rows of body(row).
template <class Body>
double sum_over_rows(size_t rows, std::vector<double>& scratch, const Body& body) {
  scratch.resize(rows);
  parallel_for(rows, kRowGrain, [&](size_t y) { scratch[y] = body(y); });
  double sum = 0;
  for (double s : scratch) sum += s;
  return sum;
}

inline double sum_of(std::span<const float> values) {
  double sum = 0;
  for (float v : values) sum += v;
  return sum;
}

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
