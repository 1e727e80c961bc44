// Depth distortion (Huang et al. 2024, "2D Gaussian Splatting", eq. 13; algorithms 1.6):  L = mean_p dist_p, the rasteriser's
// channel.
#include "core/learn/loss/loss.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

class DistortionLoss final : public Loss {
 public:
  std::string_view name() const override { return "distortion"; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const auto plane = input.raster->plane(Aov::Distortion);
    VITRINE_CHECK(!plane.empty(), "the distortion loss needs the distortion channel");
    const float step = static_cast<float>(scale / double(plane.size()));
    for (float& g : gradient.raster->plane(Aov::Distortion)) g += step;
    return sum_of(plane) / double(plane.size());
  }
};

}  // namespace

std::unique_ptr<Loss> make_distortion_loss() { return std::make_unique<DistortionLoss>(); }

}  // namespace vitrine
