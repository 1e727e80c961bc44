// Regularisers of surfel opacity and scale (Kheradmand et al. 2024, "3D Gaussian Splatting as Markov Chain Monte Carlo";
// algorithms 2.2), o = sigmoid(raw), s = exp(raw):
//   opacity:  L = mean_i o_i          dL/draw = o (1 - o) / n
//   scale:    L = mean_i (s_u + s_v)/2    dL/draw = s / (2 n)
#include <cmath>

#include "core/learn/loss/loss.h"
#include "core/learn/loss/target_mask.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {

namespace {

constexpr size_t kSurfelChunk = 4096;

// Mean of activation(raw) over an attribute; `derivative` takes the activated value.
template <class Derivative>
double mean_of_attribute(const LossInput& input, double scale, LossGradient& gradient, Attribute attribute,
                         std::vector<double>& sums, const Derivative& derivative) {
  const auto raw = input.diffuse->values(attribute);
  if (raw.empty()) return 0;
  const auto grad = gradient.diffuse->values(attribute);
  const float step = static_cast<float>(scale / double(raw.size()));
  sums.assign(chunk_count(raw.size(), kSurfelChunk), 0.0);
  parallel_chunks(raw.size(), kSurfelChunk, [&](size_t chunk, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) {
      const float value = activated_value(row(attribute).activation, raw[i]);
      sums[chunk] += value;
      grad[i] += step * derivative(value);
    }
  });
  double sum = 0;
  for (double s : sums) sum += s;
  return sum / double(raw.size());
}

class OpacityLoss final : public Loss {
 public:
  std::string_view name() const override { return "opacity"; }
  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    return mean_of_attribute(input, scale, gradient, Attribute::Opacity, sums_, [](float o) { return o * (1 - o); });
  }

 private:
  std::vector<double> sums_;
};

class ScaleLoss final : public Loss {
 public:
  std::string_view name() const override { return "scale"; }
  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    return mean_of_attribute(input, scale, gradient, Attribute::LogScale, sums_, [](float s) { return s; });
  }

 private:
  std::vector<double> sums_;
};

}  // namespace

std::unique_ptr<Loss> make_opacity_loss() { return std::make_unique<OpacityLoss>(); }
std::unique_ptr<Loss> make_scale_loss() { return std::make_unique<ScaleLoss>(); }

}  // namespace vitrine
