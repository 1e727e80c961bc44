// Binary cross-entropy between a blended channel q and a mask M (algorithms 5.4):
//   L = sum_p v [-M log q - (1 - M) log(1 - q)] / sum_p v,   v = 1 - ignore
//   transmission_mask:  q = the blended transmission weight,  M = transparent
//   object_mask:        q = the accumulated alpha,            M = object
// Outside [e, 1 - e] the logarithm is extrapolated linearly: the gradient towards the mask stays finite and non-zero.
#include "core/learn/loss/loss.h"
#include "core/learn/loss/target_kernel.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

class MaskCrossEntropyLoss final : public Loss {
 public:
  MaskCrossEntropyLoss(std::string_view name, Aov channel, std::span<const float> LossTargets::*mask)
      : name_(name), channel_(channel), mask_(mask) {}
  std::string_view name() const override { return name_; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const auto values = input.raster->plane(channel_);
    if ((input.targets.*mask_).empty() || values.empty()) return 0;
    const TargetMask mask(input, input.targets.*mask_);
    if (mask.total() <= 0) return 0;
    const auto grad = gradient.raster->plane(channel_);
    const float step = static_cast<float>(scale / mask.total());
    return mask.sum_over_pixels(row_sums_, [&](size_t i, float m, float v) {
      const ChannelTerm<float> e = cross_entropy_term(values[i], m);
      grad[i] += step * v * e.slope;
      return v * e.value;
    }) / mask.total();
  }

 private:
  std::string_view name_;
  Aov channel_;
  std::span<const float> LossTargets::*mask_;
  std::vector<double> row_sums_;
};

}  // namespace

std::unique_ptr<Loss> make_transmission_mask_loss() {
  return std::make_unique<MaskCrossEntropyLoss>("transmission_mask", Aov::Transmission, &LossTargets::transparent);
}
std::unique_ptr<Loss> make_object_mask_loss() {
  return std::make_unique<MaskCrossEntropyLoss>("object_mask", Aov::Alpha, &LossTargets::object);
}

}  // namespace vitrine
