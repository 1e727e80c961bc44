// Multi-scale structural similarity (Wang, Simoncelli, Bovik 2003):  L = 1 - prod_j v_j^a_j,  v_j the mean over level j of a
// pyramid of 2x2 averages of contrast-structure A2/B2, at the last level of the whole SSIM (ssim_kernel.h); a = the paper's
// exponents, as many as the picture has levels of a window or more, scaled to sum 1.
//   dL/dv_j = -a_j (1 - L) / v_j;  through the pyramid a fine pixel gets a quarter of its coarse one's gradient.
// A level that does not resemble the photo at all (v_j below a floor) counts as the floor and pulls at nothing.
#include <algorithm>
#include <cmath>

#include "core/loss/loss.h"
#include "core/loss/windowed_similarity.h"

namespace vitrine {

namespace {

constexpr std::array<double, 5> kExponents{0.0448, 0.2856, 0.3001, 0.2363, 0.1333};
constexpr double kFloor = 1e-3;

struct ContrastStructure {
  template <class V>
  static SsimPoint<V> at(const SsimMoments<V>& m) {
    return contrast_structure_point<V>(m);
  }
};

struct Level {
  int width = 0, height = 0;
  std::vector<float> x, y, weight, grad;  // x, y, grad: [3,h,w]
  PicturePair pair() const { return {width, height, x.data(), y.data(), weight}; }
  size_t stride() const { return static_cast<size_t>(width); }
};

// Averages of 2x2; an odd last row or column is left out.
void halve(const std::vector<float>& fine, const Level& from, Level& to, size_t planes, std::vector<float>& out) {
  const size_t w = to.stride(), h = static_cast<size_t>(to.height), fine_h = static_cast<size_t>(from.height);
  out.resize(planes * w * h);
  parallel_for(planes * h, kRowGrain, [&](size_t row) {
    const float* top = fine.data() + (row / h * fine_h + 2 * (row % h)) * from.stride();
    const float* bottom = top + from.stride();
    for (size_t x = 0; x < w; ++x) out[row * w + x] = 0.25f * (top[2 * x] + top[2 * x + 1] + bottom[2 * x] + bottom[2 * x + 1]);
  });
}

class MsSsimLoss final : public Loss {
 public:
  std::string_view name() const override { return "ms_ssim"; }
  void describe_options(Describer&) override {}

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    const size_t count = build_pyramid(input);
    double exponents = 0;
    for (size_t j = 0; j < count; ++j) exponents += kExponents[j];
    std::array<double, kExponents.size()> value{}, total{};
    double product = 1;
    for (size_t j = 0; j < count; ++j) {
      total[j] = levels_[j].pair().total_weight();
      if (total[j] <= 0) return 0;
      value[j] =
          1 - (j + 1 < count ? detail_[j].dissimilarity(levels_[j].pair()) : last_.dissimilarity(levels_[j].pair())) / total[j];
      product *= std::pow(std::max(value[j], kFloor), kExponents[j] / exponents);
    }
    for (size_t j = count; j-- > 0;) {
      Level& level = levels_[j];
      level.grad.assign(level.x.size(), 0.f);
      const double slope = value[j] > kFloor ? -scale * kExponents[j] / exponents * product / value[j] / total[j] : 0;
      if (slope != 0 && j + 1 < count)
        detail_[j].add_gradient(level.pair(), static_cast<float>(slope), level.grad.data());
      else if (slope != 0)
        last_.add_gradient(level.pair(), static_cast<float>(slope), level.grad.data());
      if (j + 1 < count) add_from_coarse(levels_[j + 1], level);
    }
    const std::vector<float>& finest = levels_[0].grad;
    parallel_chunks(finest.size(), kGrain, [&](size_t, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) gradient.prediction_srgb[i] += finest[i];
    });
    return 1 - product;
  }

 private:
  static constexpr size_t kGrain = 1 << 15;

  size_t build_pyramid(const LossInput& input) {
    Level& first = levels_[0];
    first.width = input.view->intrinsics.width;
    first.height = input.view->intrinsics.height;
    first.x.assign(input.prediction_srgb.begin(), input.prediction_srgb.end());
    first.y.assign(input.target_srgb.begin(), input.target_srgb.end());
    first.weight.assign(input.weight.begin(), input.weight.end());
    size_t count = 1;
    for (; count < levels_.size(); ++count) {
      const Level& fine = levels_[count - 1];
      Level& coarse = levels_[count];
      coarse.width = fine.width / 2;
      coarse.height = fine.height / 2;
      if (std::min(coarse.width, coarse.height) < 2 * kSsimRadius + 1) break;
      halve(fine.x, fine, coarse, 3, coarse.x);
      halve(fine.y, fine, coarse, 3, coarse.y);
      coarse.weight.clear();
      if (!fine.weight.empty()) halve(fine.weight, fine, coarse, 1, coarse.weight);
    }
    return count;
  }

  static void add_from_coarse(const Level& coarse, Level& fine) {
    const size_t h = static_cast<size_t>(coarse.height), fine_h = static_cast<size_t>(fine.height);
    parallel_for(3 * h, kRowGrain, [&](size_t row) {
      float* top = fine.grad.data() + (row / h * fine_h + 2 * (row % h)) * fine.stride();
      for (float* line : {top, top + fine.stride()})
        for (size_t x = 0; x < 2 * coarse.stride(); ++x) line[x] += 0.25f * coarse.grad[row * coarse.stride() + x / 2];
    });
  }

  std::array<Level, kExponents.size()> levels_;
  std::array<WindowedSimilarity<ContrastStructure>, kExponents.size() - 1> detail_;
  WindowedSimilarity<StructuralSimilarity> last_;
};

}  // namespace

std::unique_ptr<Loss> make_ms_ssim_loss() { return std::make_unique<MsSsimLoss>(); }

}  // namespace vitrine
