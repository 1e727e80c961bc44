// L1:  L = sum_p m_p |C_p - C_p^photo|_1 / (3 sum_p m_p), with m the weight map (1 if none is given).
//      dL/dC = m_p sign(C_p - C_p^photo) / (3 sum m).
#include <cmath>

#include "core/learn/loss/loss.h"
#include "core/learn/loss/target_mask.h"

namespace vitrine {

namespace {

class L1Loss final : public Loss {
 public:
  std::string_view name() const override { return "l1"; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const size_t pixels = input.prediction_srgb.size() / 3;
    const size_t width = static_cast<size_t>(input.view->intrinsics.width), rows = 3 * pixels / width;
    const double total = 3 * (input.weight.empty() ? static_cast<double>(pixels) : sum_of(input.weight));
    if (total <= 0) return 0;
    const float step = static_cast<float>(scale / total);
    const float *prediction = input.prediction_srgb.data(), *target = input.target_srgb.data();
    float* grad = gradient.prediction_srgb.data();
    return sum_over_rows(rows, row_sums_,
                         [&](size_t row) {
                           const size_t begin = row * width, mask = begin % pixels;
                           float sum = 0;
                           for (size_t x = 0; x < width; ++x) {
                             const float m = input.weight.empty() ? 1.f : input.weight[mask + x];
                             const float difference = prediction[begin + x] - target[begin + x];
                             sum += m * std::abs(difference);
                             grad[begin + x] += difference == 0.f ? 0.f : std::copysign(m * step, difference);
                           }
                           return static_cast<double>(sum);
                         }) /
           total;
  }

 private:
  std::vector<double> row_sums_;
};

}  // namespace

std::unique_ptr<Loss> make_l1_loss() { return std::make_unique<L1Loss>(); }

}  // namespace vitrine
