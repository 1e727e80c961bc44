// Target normals of one picture (network, file or geometry) (algorithms 5.4), n = R N/|N| the blended normal in the camera
// frame, n_t the target, c its confidence:
//   L = sum_p v c (|n - n_t|_1 + 1 - n . n_t) / P,   v = 1 - ignore, P the pixels of the frame
//   dL/dN = R^T (I - n n^T) g / |N|
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/learn/loss/loss.h"
#include "core/learn/loss/target_kernel.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

class MonocularNormalLoss final : public Loss {
 public:
  std::string_view name() const override { return "monocular_normal"; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    if (input.targets.normals.empty()) return 0;
    const size_t width = static_cast<size_t>(input.view->intrinsics.width);
    const size_t height = static_cast<size_t>(input.view->intrinsics.height), pixels = width * height;
    const auto target = input.targets.normals, confidence = input.targets.normal_confidence, ignore = input.targets.ignore;
    VITRINE_CHECK(target.size() == 3 * pixels && (confidence.empty() || confidence.size() == pixels) &&
                      (ignore.empty() || ignore.size() == pixels),
                  "normal targets of another size than the frame");
    const auto alpha = input.raster->plane(Aov::Alpha), normal = input.raster->plane(Aov::Normal);
    const auto grad = gradient.raster->plane(Aov::Normal);
    const Mat3f cam_from_world = cast<float>(input.view->cam_from_world.rotation), world_from_cam = transposed(cam_from_world);
    const float step = static_cast<float>(scale / double(pixels));
    return sum_over_rows(height, row_sums_,
                         [&](size_t y) {
                           double sum = 0;
                           for (size_t i = y * width; i < (y + 1) * width; ++i) {
                             const Vec3f t{target[i], target[pixels + i], target[2 * pixels + i]};
                             if (dot(t, t) < UsableNormal::kShortestTarget || alpha[i] < UsableNormal::kLeastAlpha) continue;
                             const Vec3f blended{normal[i], normal[pixels + i], normal[2 * pixels + i]};
                             const float length = std::sqrt(dot(blended, blended));
                             if (length < UsableNormal::kShortest) continue;
                             const float weight =
                                 (confidence.empty() ? 1.f : confidence[i]) * (ignore.empty() ? 1.f : 1.f - ignore[i]);
                             if (weight <= 0) continue;
                             const Vec3f n = (1 / length) * (cam_from_world * blended);
                             const TargetNormalTerm<float> term = target_normal_term(n, t);
                             sum += weight * term.value;
                             const Vec3f back = (step * weight / length) * (world_from_cam * term.tangent);
                             for (size_t c = 0; c < 3; ++c) grad[c * pixels + i] += back[c];
                           }
                           return sum;
                         }) /
           double(pixels);
  }

 private:
  std::vector<double> row_sums_;
};

}  // namespace

std::unique_ptr<Loss> make_monocular_normal_loss() { return std::make_unique<MonocularNormalLoss>(); }

}  // namespace vitrine
