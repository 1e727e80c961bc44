// Normals of one picture (network, file or geometry) as targets (algorithms 5.4), n = R N/|N| the blended normal in the camera
// frame, n_t the target, c its confidence:
//   L = sum_p v c d (|n - n_t|_1 + 1 - n . n_t) / P,   v = 1 - ignore, P the pixels of the frame
//   d = clip(1 - (z - z_1) / (z_99 - z_1), 0, 1) with `near_first` (z_1, z_99: percentiles of the rendered depth, held constant),
//       else 1: in a scene without bounds the far things have normals that nobody can see.
//   dL/dN = R^T (I - n n^T) g / |N|
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/loss/loss.h"
#include "core/loss/row_sum.h"
#include "core/math/quantile.h"

namespace vitrine {

namespace {

class MonocularNormalLoss final : public Loss {
 public:
  std::string_view name() const override { return "monocular_normal"; }
  void describe_options(Describer& d) override {
    d.option("near_first", near_first_, "Weigh pixels by inverse normalised depth (scenes without bounds).");
    d.option("min_alpha", min_alpha_, "Pixels with less alpha have no usable normal.").range(1e-3, 1);
  }

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
    const DepthRange range = near_first_ ? depth_range(*input.raster) : DepthRange{};
    const float step = static_cast<float>(scale / double(pixels));
    return sum_over_rows(height, row_sums_,
                         [&](size_t y) {
                           double sum = 0;
                           for (size_t i = y * width; i < (y + 1) * width; ++i) {
                             const Vec3f t{target[i], target[pixels + i], target[2 * pixels + i]};
                             if (dot(t, t) < 0.25f || alpha[i] < min_alpha_) continue;
                             const Vec3f blended{normal[i], normal[pixels + i], normal[2 * pixels + i]};
                             const float length = std::sqrt(dot(blended, blended));
                             if (length < kShortest) continue;
                             float weight = (confidence.empty() ? 1.f : confidence[i]) * (ignore.empty() ? 1.f : 1.f - ignore[i]);
                             if (near_first_) weight *= range.nearness(input.raster->plane(Aov::ZDepth)[i] / alpha[i]);
                             if (weight <= 0) continue;
                             const Vec3f n = (1 / length) * (cam_from_world * blended);
                             Vec3f g = -t;
                             float value = 1 - dot(n, t);
                             for (size_t c = 0; c < 3; ++c) {
                               const float off = n[c] - t[c];
                               value += std::abs(off);
                               if (off != 0) g[c] += std::copysign(1.f, off);
                             }
                             sum += weight * value;
                             const Vec3f back = (step * weight / length) * (world_from_cam * (g - dot(n, g) * n));
                             for (size_t c = 0; c < 3; ++c) grad[c * pixels + i] += back[c];
                           }
                           return sum;
                         }) /
           double(pixels);
  }

 private:
  static constexpr float kShortest = 0.05f;  // opposed normals that cancel have no direction

  struct DepthRange {
    float near = 0, far = 1;
    float nearness(float z) const { return far > near ? std::clamp(1 - (z - near) / (far - near), 0.f, 1.f) : 1.f; }
  };
  DepthRange depth_range(const RasterImages& raster) {
    const auto zdepth = raster.plane(Aov::ZDepth), alpha = raster.plane(Aov::Alpha);
    depths_.clear();
    for (size_t i = 0; i < alpha.size(); ++i)
      if (alpha[i] >= min_alpha_) depths_.push_back(zdepth[i] / alpha[i]);
    if (depths_.empty()) return {};
    const auto percentile = [&](size_t hundredth) {
      return order_statistic_of(std::span(depths_), (depths_.size() - 1) * hundredth / 100);
    };
    return {percentile(1), percentile(99)};
  }

  bool near_first_ = false;
  float min_alpha_ = 0.3f;
  std::vector<float> depths_;
  std::vector<double> row_sums_;
};

}  // namespace

std::unique_ptr<Loss> make_monocular_normal_loss() { return std::make_unique<MonocularNormalLoss>(); }

}  // namespace vitrine
