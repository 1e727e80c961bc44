// D-SSIM:  L = sum_p m_p (1 - S_p) / sum_p m_p, averaged over the channels; S by ssim_kernel.h with zero padding.
#include "core/loss/loss.h"
#include "core/loss/windowed_similarity.h"

namespace vitrine {

namespace {

class DssimLoss final : public Loss {
 public:
  std::string_view name() const override { return "dssim"; }
  void describe_options(Describer&) override {}

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const PicturePair pair{input.view->intrinsics.width, input.view->intrinsics.height, input.prediction_srgb.data(),
                           input.target_srgb.data(), input.weight};
    const double total = pair.total_weight();
    if (total <= 0) return 0;
    const double sum = similarity_.dissimilarity(pair);
    similarity_.add_gradient(pair, static_cast<float>(-scale / total), gradient.prediction_srgb.data());
    return sum / total;
  }

 private:
  WindowedSimilarity<StructuralSimilarity> similarity_;
};

}  // namespace

std::unique_ptr<Loss> make_dssim_loss() { return std::make_unique<DssimLoss>(); }

}  // namespace vitrine
