#include "stages/masks/onnx/class_values.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/config/describe.h"

namespace vitrine {

namespace {

// Of one pixel, before the threshold.
double belonging(const NetworkOutput& out, size_t pixel, const std::string& activation, std::span<const double> channels) {
  const auto listed = [&](int number) { return std::find(channels.begin(), channels.end(), double(number)) != channels.end(); };
  if (activation == "labels") return listed(int(std::lround(std::clamp(out.at(pixel, 0), -1.f, 1e6f)))) ? 1 : 0;
  if (activation == "argmax") {
    int best = 0;
    for (int c = 1; c < out.channels; ++c)
      if (out.at(pixel, c) > out.at(pixel, best)) best = c;
    return listed(best) ? 1 : 0;
  }
  if (activation == "softmax") {
    double top = -INFINITY, all = 0, ours = 0;
    for (int c = 0; c < out.channels; ++c) top = std::max(top, double(out.at(pixel, c)));
    for (int c = 0; c < out.channels; ++c) {
      const double weight = std::exp(double(out.at(pixel, c)) - top);
      all += weight;
      if (listed(c)) ours += weight;
    }
    return ours / all;
  }
  double largest = -INFINITY;
  for (double c : channels) largest = std::max(largest, double(out.at(pixel, int(c))));
  return activation == "sigmoid" ? 1 / (1 + std::exp(-largest)) : std::clamp(largest, 0.0, 1.0);
}

}  // namespace

const std::vector<double>& NetworkMasksConfig::channels_of(MaskClass kind) const {
  switch (kind) {
    case MaskClass::Object:
      return object;
    case MaskClass::Transparent:
      return transparent;
    case MaskClass::Specular:
      return specular;
    case MaskClass::Ignore:
      return ignore;
  }
  return object;
}

std::string NetworkMasksConfig::problem() const {
  if (std::string p = input.problem("masks.onnx."); !p.empty()) return p;
  if (activation == "labels" && outputs != 1)
    return "masks.onnx.activation is labels: one number a pixel, so masks.onnx.outputs is 1";
  if ((activation == "softmax" || activation == "argmax") && outputs < 2)
    return fmt::format("masks.onnx.activation {} compares channels, so masks.onnx.outputs is 2 or more", activation);
  for (MaskClass kind : kMaskClasses)
    for (double c : channels_of(kind))
      if (c < 0 || c != std::floor(c) || c > 1e6 || (activation != "labels" && c >= outputs))
        return fmt::format("masks.onnx.{} names {}, which is no channel of 0 to {}", name(kind), c, outputs - 1);
  return {};
}

void describe(Describer& d, NetworkMasksConfig& c) {
  describe_input(d, c.input);
  d.option("outputs", c.outputs, "Channels of its output, that of the background included.").range(1, 4096);
  d.option("activation", c.activation,
           "What its output is: logits (sigmoid: classes of their own, softmax: one of them), probabilities, logits of which the "
           "largest counts (argmax), or one label a pixel.")
      .choices({"sigmoid", "softmax", "probability", "argmax", "labels"});
  d.option("object", c.object, "Channels (labels) that mean the object; empty = none.");
  d.option("transparent", c.transparent, "Channels (labels) that mean glass; empty = none.");
  d.option("specular", c.specular, "Channels (labels) that mean what mirrors, glass included; empty = none.");
  d.option("ignore", c.ignore, "Channels (labels) that mean what no photo should be held to; empty = none.");
  d.option("threshold", c.threshold, "Probability from which on a pixel belongs; it is written as one half.").range(0.01, 0.99);
  d.option("soft", c.soft, "Write the probabilities; false: yes or no.");
  d.option("confidence", c.confidence, "Factor on the confidence, which is 0 at the threshold.").range(0, 1);
  d.option("vote", c.vote, "Let the photos vote: where a class does not hold still in space, the others overrule a photo.");
  d.option("resolution", c.resolution, "Voxels along the longest side of what is voted on.").range(16, 512);
}

std::vector<float> class_values(const NetworkOutput& out, const NetworkMasksConfig& config, std::span<const double> channels,
                                const std::string& where) {
  if (!std::all_of(out.values.begin(), out.values.end(), [](float v) { return std::isfinite(v); }))
    throw Error(ErrorKind::Input, "the network gives what is no number",
                {.where = where,
                 .why = fmt::format("in its output of {}", out.shape),
                 .hint = "masks.onnx.mean and deviation must be what it was trained with",
                 .code = "BAD_NETWORK_OUTPUT"});
  std::vector<float> values(out.pixel_count());
  const double t = config.threshold;
  const bool graded = config.activation != "labels" && config.activation != "argmax";
  for (size_t i = 0; i < values.size(); ++i) {
    double v = belonging(out, i, config.activation, channels);
    if (graded) v = std::clamp(v < t ? v / t - 0.5 : (v - t) / (1 - t) + 0.5, 0.0, 1.0);
    values[i] = float(config.soft ? v : v >= 0.5 ? 1 : 0);
  }
  return values;
}

}  // namespace vitrine
