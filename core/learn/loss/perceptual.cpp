// Perceptual distance in the features of a convolutional network (LPIPS without its learned weights; Zhang et al. 2018):
//   L = 1/T sum_t 1/P_t sum_p |f_t(C)_p - f_t(C_photo)_p|^2,   f = features / sqrt(|features|^2 + e) over the channels of a pixel
// T features, P_t pixels each, on one square crop of the picture, sampled for every step from the step index and the view's name.
//   dL/dF = (g - f (f . g)) / sqrt(|F|^2 + e),  g = 2 (f - f_photo) / (T P_t); the network's backward pass does the rest.
// Off without a weights file.
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/learn/loss/feature_network.h"
#include "core/learn/loss/loss.h"

namespace vitrine {

namespace {

constexpr float kSmall = 1e-8f;
enum : uint64_t { kCropStream = 0x9ce7 };

uint64_t hash_of(std::string_view text) {
  uint64_t h = kCropStream;
  for (char c : text) h = mix64(h, static_cast<unsigned char>(c));
  return h;
}

class PerceptualLoss final : public Loss {
 public:
  PerceptualLoss(std::string weights, int crop, int every) : weights_(std::move(weights)), crop_(crop), every_(every) {}
  std::string_view name() const override { return "perceptual"; }
  void describe_options(Describer& d) override {
    d.option("vgg", weights_, "safetensors file of a VGG network (core/learn/loss/README.md); empty = no perceptual loss.")
        .file();
  }
  bool takes_part(uint64_t step) const override { return !weights_.empty() && step % static_cast<uint64_t>(every_) == 0; }

  double evaluate(const LossInput& input, double scale, LossGradient& gradient) override {
    if (!takes_part(input.step)) return 0;
    if (!network_ || loaded_ != weights_) {
      network_.emplace(weights_);
      loaded_ = weights_;
    }
    const Crop crop = crop_of(input);
    const auto features = network_->prepare(crop.width, crop.height);
    if (features.empty()) return 0;
    parallel_for(2, 1, [&](size_t which) {
      std::vector<float> rgb = pixels(which == 0 ? input.prediction_srgb : input.target_srgb, crop);
      network_->forward(rgb, activations_[which]);
    });
    grad_features_.resize(features.size());
    double sum = 0;
    for (size_t t = 0; t < features.size(); ++t) {
      const size_t count = static_cast<size_t>(features[t].width) * static_cast<size_t>(features[t].height);
      sum += distance(activations_[0].after_convolution[features[t].convolution],
                      activations_[1].after_convolution[features[t].convolution], static_cast<size_t>(features[t].channels),
                      1.0 / (double(features.size()) * double(count)), grad_features_[t]);
    }
    grad_rgb_.resize(3 * static_cast<size_t>(crop.width) * static_cast<size_t>(crop.height));
    network_->backward(activations_[0], grad_features_, grad_rgb_);
    const float step = static_cast<float>(scale * every_);
    for_pixels(crop,
               [&](size_t in_picture, size_t in_crop) { gradient.prediction_srgb[in_picture] += step * grad_rgb_[in_crop]; });
    return sum * every_;
  }

 private:
  struct Crop {
    int x, y, width, height;
    size_t picture_width, picture_height;
  };

  Crop crop_of(const LossInput& input) const {
    const int width = input.view->intrinsics.width, height = input.view->intrinsics.height;
    const int w = std::min(crop_, width), h = std::min(crop_, height);
    Rng rng(hash_of(input.view->name), input.step);
    const int x = static_cast<int>(rng.below(static_cast<uint32_t>(width - w + 1)));
    const int y = static_cast<int>(rng.below(static_cast<uint32_t>(height - h + 1)));
    return {x, y, w, h, static_cast<size_t>(width), static_cast<size_t>(height)};
  }

  // body(index in the planar picture, index in the crop with channels last)
  template <class Body>
  static void for_pixels(const Crop& crop, const Body& body) {
    const size_t w = static_cast<size_t>(crop.width), h = static_cast<size_t>(crop.height);
    for (size_t c = 0; c < 3; ++c)
      for (size_t y = 0; y < h; ++y)
        for (size_t x = 0; x < w; ++x)
          body((c * crop.picture_height + y + static_cast<size_t>(crop.y)) * crop.picture_width + x + static_cast<size_t>(crop.x),
               (y * w + x) * 3 + c);
  }
  static std::vector<float> pixels(std::span<const float> picture, const Crop& crop) {
    std::vector<float> rgb(3 * static_cast<size_t>(crop.width) * static_cast<size_t>(crop.height));
    for_pixels(crop, [&](size_t from, size_t to) { rgb[to] = picture[from]; });
    return rgb;
  }

  // Sum over pixels of |f_x - f_y|^2, times `weight`; grad is that of x.
  static double distance(const std::vector<float>& x, const std::vector<float>& y, size_t channels, double weight,
                         std::vector<float>& grad) {
    grad.resize(x.size());
    double sum = 0;
    std::vector<float> g(channels);
    for (size_t p = 0; p < x.size(); p += channels) {
      float xx = kSmall, yy = kSmall;
      for (size_t c = 0; c < channels; ++c) xx += x[p + c] * x[p + c], yy += y[p + c] * y[p + c];
      const float ix = 1 / std::sqrt(xx), iy = 1 / std::sqrt(yy);
      float along = 0, square = 0;
      for (size_t c = 0; c < channels; ++c) {
        const float d = x[p + c] * ix - y[p + c] * iy;
        square += d * d;
        g[c] = 2 * static_cast<float>(weight) * d;
        along += g[c] * x[p + c] * ix;
      }
      sum += square;
      for (size_t c = 0; c < channels; ++c) grad[p + c] = (g[c] - along * x[p + c] * ix) * ix;
    }
    return weight * sum;
  }

  std::string weights_, loaded_;
  int crop_, every_;
  std::optional<FeatureNetwork> network_;
  FeatureNetwork::Activations activations_[2];
  std::vector<std::vector<float>> grad_features_;
  std::vector<float> grad_rgb_;
};

}  // namespace

std::unique_ptr<Loss> make_perceptual_loss(std::string vgg, int crop, int every) {
  return std::make_unique<PerceptualLoss>(std::move(vgg), crop, every);
}

}  // namespace vitrine
