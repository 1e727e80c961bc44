// Normal consistency (Huang et al. 2024, eq. 14; algorithms 1.8):  L = mean_p A_p (1 - N_p . n_d(p)),  n_d from central
// differences of P(x, y) = z d(x, y) in the camera frame, z = Z/A the mean depth.
// Two passes without scatter: first the gradients of the two differences per pixel; then every pixel gathers from its four
// neighbours.
#include <algorithm>

#include "core/learn/loss/loss.h"
#include "core/learn/loss/normal_kernel.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

class NormalConsistencyLoss final : public Loss {
 public:
  std::string_view name() const override { return "normal_consistency"; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const Intrinsics& camera = input.view->intrinsics;
    const size_t width = static_cast<size_t>(camera.width), height = static_cast<size_t>(camera.height), pixels = width * height;
    if (width < 3 || height < 3) return 0;
    const Mat3f cam_from_world = cast<float>(input.view->cam_from_world.rotation);
    const Mat3f world_from_cam = transposed(cam_from_world);
    // The ray through a pixel is (ray_x, ray_y, 1): pinhole cameras.
    ray_x_.resize(width);
    ray_y_.resize(height);
    for (size_t x = 0; x < width; ++x) ray_x_[x] = static_cast<float>(camera.ray(double(x) + 0.5, 0.5).x);
    for (size_t y = 0; y < height; ++y) ray_y_[y] = static_cast<float>(camera.ray(0.5, double(y) + 0.5).y);
    const auto ray = [&](size_t x, size_t y) { return Vec3f{ray_x_[x], ray_y_[y], 1.f}; };

    const auto zdepth = input.raster->plane(Aov::ZDepth), alpha = input.raster->plane(Aov::Alpha);
    const auto normal = input.raster->plane(Aov::Normal);
    depth_.resize(pixels);
    slope_down_.resize(pixels);
    slope_right_.resize(pixels);
    parallel_for(height, kRowGrain, [&](size_t y) {
      for (size_t i = y * width; i < (y + 1) * width; ++i)  // 0 marks a pixel without depth
        depth_[i] = alpha[i] < kLeastAlphaOfDepth ? 0.f : zdepth[i] / alpha[i];
    });

    const float pixel_scale = static_cast<float>(scale / double(pixels));
    const auto grad_normal = gradient.raster->plane(Aov::Normal);
    const double sum = sum_over_rows(height, row_sums_, [&](size_t y) {
      double row = 0;
      for (auto* slope : {&slope_down_, &slope_right_}) std::fill_n(slope->data() + y * width, width, Vec3f{});
      if (y == 0 || y + 1 == height) return row;
      for (size_t x = 1; x + 1 < width; ++x) {
        const size_t i = y * width + x;
        const float up = depth_[i - width], down = depth_[i + width], left = depth_[i - 1], right = depth_[i + 1];
        if (depth_[i] <= 0 || up <= 0 || down <= 0 || left <= 0 || right <= 0) continue;
        const Vec3f a = down * ray(x, y + 1) - up * ray(x, y - 1), b = right * ray(x + 1, y) - left * ray(x - 1, y);
        const Vec3f n = cam_from_world * Vec3f{normal[i], normal[pixels + i], normal[2 * pixels + i]};
        const NormalTerm<float> term = normal_term(n, a, b, alpha[i]);
        row += term.value;
        const Vec3f g = pixel_scale * (world_from_cam * term.grad_normal);
        for (size_t c = 0; c < 3; ++c) grad_normal[c * pixels + i] += g[c];
        slope_down_[i] = pixel_scale * term.grad_a;
        slope_right_[i] = pixel_scale * term.grad_b;
      }
      return row;
    });

    const auto grad_z = gradient.raster->plane(Aov::ZDepth), grad_alpha = gradient.raster->plane(Aov::Alpha);
    parallel_for(height, kRowGrain, [&](size_t y) {
      for (size_t x = 0; x < width; ++x) {
        const size_t i = y * width + x;
        if (depth_[i] <= 0) continue;
        Vec3f g{};
        if (y > 0) g += slope_down_[i - width];
        if (y + 1 < height) g -= slope_down_[i + width];
        if (x > 0) g += slope_right_[i - 1];
        if (x + 1 < width) g -= slope_right_[i + 1];
        const float grad_depth = dot(g, ray(x, y));
        grad_z[i] += grad_depth / alpha[i];
        grad_alpha[i] -= grad_depth * zdepth[i] / (alpha[i] * alpha[i]);
      }
    });
    return sum / double(pixels);
  }

 private:
  std::vector<float> depth_, ray_x_, ray_y_;
  std::vector<Vec3f> slope_down_, slope_right_;  // gradients of the two central differences
  std::vector<double> row_sums_;
};

}  // namespace

std::unique_ptr<Loss> make_normal_consistency_loss() { return std::make_unique<NormalConsistencyLoss>(); }

}  // namespace vitrine
