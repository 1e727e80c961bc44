// L1 in the gradient domain:  L = sum |(e_q - e_p)| m / (3 sum m),  e = C - C_photo, over the pairs (p, q) of a pixel and its
// right or lower neighbour, m the smaller of the two pixels' weights. Blind to a constant offset, sensitive to edges and texture.
//   dL/de_q = m sign(e_q - e_p) / (3 sum m) = -dL/de_p, gathered per pixel from its four pairs.
#include <algorithm>
#include <cmath>

#include "core/loss/loss.h"
#include "core/loss/row_sum.h"

namespace vitrine {

namespace {

class GradientL1Loss final : public Loss {
 public:
  std::string_view name() const override { return "gradient_l1"; }
  void describe_options(Describer&) override {}

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const size_t width = static_cast<size_t>(input.view->intrinsics.width);
    const size_t height = static_cast<size_t>(input.view->intrinsics.height), pixels = width * height;
    const double total = 3 * pair_weight(input.weight, width, height);
    if (total <= 0) return 0;
    const float step = static_cast<float>(scale / total);
    const float *prediction = input.prediction_srgb.data(), *target = input.target_srgb.data();
    const auto error = [&](size_t i) { return prediction[i] - target[i]; };
    const auto weight = [&](size_t p, size_t q) {
      return input.weight.empty() ? 1.f : std::min(input.weight[p % pixels], input.weight[q % pixels]);
    };
    float* grad = gradient.prediction_srgb.data();
    return sum_over_rows(3 * height, row_sums_,
                         [&](size_t row) {
                           const size_t y = row % height, begin = row * width;
                           double sum = 0;
                           for (size_t x = 0; x < width; ++x) {
                             const size_t i = begin + x;
                             float slope = 0;
                             const auto pair = [&](size_t other) {  // returns what the pair adds to the value
                               const float m = weight(i, other), difference = error(i) - error(other);
                               if (difference != 0) slope += std::copysign(m, difference);
                               return m * std::abs(difference);
                             };
                             // A pair is counted at its first pixel; its gradient goes to both.
                             if (x + 1 < width) sum += pair(i + 1);
                             if (y + 1 < height) sum += pair(i + width);
                             if (x > 0) pair(i - 1);
                             if (y > 0) pair(i - width);
                             grad[i] += step * slope;
                           }
                           return sum;
                         }) /
           total;
  }

 private:
  static double pair_weight(std::span<const float> weight, size_t width, size_t height) {
    if (weight.empty()) return double((width - 1) * height + width * (height - 1));
    double sum = 0;
    for (size_t y = 0; y < height; ++y)
      for (size_t x = 0; x < width; ++x) {
        const size_t i = y * width + x;
        if (x + 1 < width) sum += std::min(weight[i], weight[i + 1]);
        if (y + 1 < height) sum += std::min(weight[i], weight[i + width]);
      }
    return sum;
  }

  std::vector<double> row_sums_;
};

}  // namespace

std::unique_ptr<Loss> make_gradient_l1_loss() { return std::make_unique<GradientL1Loss>(); }

}  // namespace vitrine
