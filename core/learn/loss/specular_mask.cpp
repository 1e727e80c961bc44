// Specular weight against the specular mask (algorithms 5.4), K the blended specular weight, M the mask:
//   L = sum_p v (1 - T) [(1 - M) K + b M max(0, K0 - K)] / sum_p v,   v = 1 - ignore
// Outside the mask K is pushed to zero; inside, K must reach K0, and the photos determine larger values. Pixels of the
// transparent mask T and of coats are excluded: they reflect by Fresnel's equations however small their K, and K0 would turn
// them into mirrors.
#include "core/foundation/base/error.h"
#include "core/learn/loss/loss.h"
#include "core/learn/loss/target_kernel.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

class SpecularMaskLoss final : public Loss {
 public:
  std::string_view name() const override { return "specular_mask"; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const auto weight = input.raster->plane(Aov::SpecularWeight);
    if (input.targets.specular.empty() || weight.empty()) return 0;
    const TargetMask mask(input, input.targets.specular);
    if (mask.total() <= 0) return 0;
    const auto grad = gradient.raster->plane(Aov::SpecularWeight);
    const std::span<const float> glass = input.targets.transparent;
    const std::span<const float> coat = input.targets.coat;
    VITRINE_CHECK(glass.empty() || glass.size() == weight.size(), "a transparent mask of {} pixels", glass.size());
    VITRINE_CHECK(coat.empty() || coat.size() == weight.size(), "a mask of coats of {} pixels", coat.size());
    const float step = static_cast<float>(scale / mask.total());
    return mask.sum_over_pixels(row_sums_, [&](size_t i, float m, float valid) {
      const float v = valid * (glass.empty() ? 1 : 1 - glass[i]) * (coat.empty() ? 1 : 1 - coat[i]);
      const ChannelTerm<float> term = specular_mask_term(weight[i], m);
      grad[i] += step * v * term.slope;
      return v * term.value;
    }) / mask.total();
  }

 private:
  std::vector<double> row_sums_;
};

}  // namespace

std::unique_ptr<Loss> make_specular_mask_loss() { return std::make_unique<SpecularMaskLoss>(); }

}  // namespace vitrine
