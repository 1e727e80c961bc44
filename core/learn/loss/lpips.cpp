#include "core/learn/loss/lpips.h"

#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"

namespace vitrine {
namespace {

constexpr double kSmall = 1e-10;
constexpr int kProbeSide = 64;  // a picture in which every feature of VGG16 has a pixel

double weighted_distance(const std::vector<float>& x, const std::vector<float>& y, const std::vector<float>& weights) {
  const size_t channels = weights.size();
  double sum = 0;
  for (size_t p = 0; p < x.size(); p += channels) {
    double xx = 0, yy = 0;
    for (size_t c = 0; c < channels; ++c) xx += double(x[p + c]) * double(x[p + c]), yy += double(y[p + c]) * double(y[p + c]);
    const double ix = 1 / (std::sqrt(xx) + kSmall), iy = 1 / (std::sqrt(yy) + kSmall);
    for (size_t c = 0; c < channels; ++c) {
      const double d = double(x[p + c]) * ix - double(y[p + c]) * iy;
      sum += double(weights[c]) * d * d;
    }
  }
  return sum / (double(x.size()) / double(channels));
}

}  // namespace

Lpips::Lpips(const std::filesystem::path& weights) : network_(weights) {
  const auto heads = read_safetensors(weights, "lin");
  for (const FeatureNetwork::Feature& feature : network_.prepare(kProbeSide, kProbeSide)) {
    const std::string name = fmt::format("lin{}.model.1.weight", channel_weights_.size());
    const auto head = heads.find(name);
    if (head == heads.end() || head->second.values.size() != size_t(feature.channels))
      throw Error(ErrorKind::Input, "a file has no weights of LPIPS",
                  {.where = weights.string(),
                   .why = head == heads.end() ? fmt::format("the tensor {} is missing", name)
                                              : fmt::format("{} has {} values for {} channels", name, head->second.values.size(),
                                                            feature.channels),
                   .hint = "join the network and the weights of LPIPS in one file: core/learn/loss/README.md",
                   .code = "BAD_WEIGHTS"});
    channel_weights_.push_back(head->second.values);
  }
}

double Lpips::distance(const ImageF& srgb, const ImageF& reference) {
  VITRINE_CHECK(srgb.width() == reference.width() && srgb.height() == reference.height() && srgb.channels() == 3 &&
                    reference.channels() == 3,
                "two pictures of one size");
  const auto features = network_.prepare(srgb.width(), srgb.height());
  FeatureNetwork::Activations activations[2];
  parallel_for(2, 1, [&](size_t which) { network_.forward((which == 0 ? srgb : reference).data(), activations[which]); });
  double sum = 0;
  for (size_t t = 0; t < features.size(); ++t)
    sum += weighted_distance(activations[0].after_convolution[features[t].convolution],
                             activations[1].after_convolution[features[t].convolution], channel_weights_[t]);
  return sum;
}

}  // namespace vitrine
