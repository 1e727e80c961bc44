#include "stages/masks/onnx/network_source.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/foundation/config/describe.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/observe/stereo/visual_hull.h"

namespace vitrine {

namespace {

constexpr double kNetworkShare = 0.8;    // share of the progress
constexpr double kLeastAgreement = 0.3;  // minimum IoU of the hull and the photos' masks for a vote
constexpr float kOverruled = 0.3f;       // confidence where photo and hull disagree
constexpr size_t kFewestVoters = 4;
constexpr float kNetworkConfidence = 0.8f;  // factor on the confidence, which is 0 at the threshold
constexpr int kVoteVoxels = 96;             // along the longest side of what is voted on

// Of one pixel, before the threshold.
double belonging(const NetworkOutput& out, size_t pixel, NetworkActivation activation, std::span<const double> channels) {
  const auto listed = [&](int number) { return std::find(channels.begin(), channels.end(), double(number)) != channels.end(); };
  if (activation == NetworkActivation::Labels) return listed(int(std::lround(std::clamp(out.at(pixel, 0), -1.f, 1e6f)))) ? 1 : 0;
  if (activation == NetworkActivation::Argmax) {
    int best = 0;
    for (int c = 1; c < out.channels; ++c)
      if (out.at(pixel, c) > out.at(pixel, best)) best = c;
    return listed(best) ? 1 : 0;
  }
  if (activation == NetworkActivation::Softmax) {
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
  return activation == NetworkActivation::Sigmoid ? 1 / (1 + std::exp(-largest)) : std::clamp(largest, 0.0, 1.0);
}

// The photo at the input size of the network.
ImageF photo_of(const MaskCapture& capture, const View& view, int width, int height) {
  const ImageF linear = read_exr_rgb(linear_image_path(capture.sfm_folder, view));
  ImageF srgb = srgb_from_linear_image(resized(linear, width, height));
  for (float& v : srgb.data()) v = std::min(v, 1.f);
  return srgb;
}

std::vector<uint8_t> inside_of(const std::vector<float>& value) {
  std::vector<uint8_t> inside(value.size());
  std::transform(value.begin(), value.end(), inside.begin(), [](float v) { return v >= 0.5f; });
  return inside;
}

// Morphological opening with a square of 2 radius + 1 pixels.
std::vector<uint8_t> opened(const std::vector<uint8_t>& mask, const Intrinsics& k, int radius) {
  std::vector<uint8_t> from = mask, to(mask.size());
  const auto pass = [&](int dx, int dy, bool shrink) {
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        uint8_t value = shrink;
        for (int i = -radius; i <= radius; ++i) {
          const int u = std::clamp(x + i * dx, 0, k.width - 1), v = std::clamp(y + i * dy, 0, k.height - 1);
          const uint8_t near = from[size_t(v) * size_t(k.width) + size_t(u)];
          value = shrink ? value & near : value | near;
        }
        to[k.index(x, y)] = value;
      }
    std::swap(from, to);
  };
  for (const bool shrink : {true, false}) pass(1, 0, shrink), pass(0, 1, shrink);
  return from;
}

// Vote of the photos on one class.
void vote(NetworkMasks& masks, NetworkMasks::Class& c) {
  std::vector<Silhouette> photos;
  std::vector<std::vector<uint8_t>> own;
  for (size_t v = 0; v < masks.views.size(); ++v) {
    own.push_back(inside_of(c.value[v]));
    photos.push_back(silhouette(masks.views[v], own[v]));
  }
  const VisualHull hull(photos, {.resolution = kVoteVoxels, .rule = kOutlineVote});
  if (hull.empty()) return;
  const std::vector<std::vector<uint8_t>> carried = silhouettes_of(hull, masks.views);
  double sum = 0;
  size_t shown = 0;
  for (size_t v = 0; v < own.size(); ++v) {
    size_t both = 0, either = 0;
    for (size_t i = 0; i < own[v].size(); ++i) both += own[v][i] & carried[v][i], either += own[v][i] | carried[v][i];
    if (either > 0) sum += double(both) / double(either), ++shown;
  }
  c.agreement = shown > 0 ? sum / double(shown) : 0;
  c.voted = c.agreement >= kLeastAgreement;
  if (!c.voted) return;
  for (size_t v = 0; v < own.size(); ++v) {
    std::vector<uint8_t> apart(own[v].size());
    for (size_t i = 0; i < apart.size(); ++i) apart[i] = own[v][i] != carried[v][i];
    // Outlines are kept from the photo: the hull is no more precise than its voxels.
    const Intrinsics& k = masks.views[v].intrinsics;
    c.doubted.push_back(opened(apart, k, std::max(1, k.longest_side() / kVoteVoxels)));
    for (size_t i = 0; i < apart.size(); ++i)
      if (c.doubted[v][i]) c.value[v][i] = carried[v][i];
  }
}

}  // namespace

const std::vector<double>& NetworkMasksConfig::channels_of(MaskClass kind) const {
  const std::vector<double>* all[] = {&object, &transparent, &specular, &ignore};
  return *all[size_t(kind)];
}

std::string NetworkMasksConfig::problem() const {
  if (std::string p = input.problem("masks.onnx."); !p.empty()) return p;
  if (activation == NetworkActivation::Labels && outputs != 1)
    return "masks.onnx.activation is labels: one number a pixel, so masks.onnx.outputs is 1";
  if ((activation == NetworkActivation::Softmax || activation == NetworkActivation::Argmax) && outputs < 2)
    return fmt::format("masks.onnx.activation {} compares channels, so masks.onnx.outputs is 2 or more",
                       kNetworkActivationWords[size_t(activation)]);
  for (MaskClass kind : kMaskClasses)
    for (double c : channels_of(kind))
      if (c < 0 || c != std::floor(c) || c > 1e6 || (activation != NetworkActivation::Labels && c >= outputs))
        return fmt::format("masks.onnx.{} names {}, which is no channel of 0 to {}", name(kind), c, outputs - 1);
  return {};
}

void describe(Describer& d, NetworkMasksConfig& c) {
  describe_input(d, c.input);
  d.option("outputs", c.outputs, "Channels of its output, that of the background included.").range(1, 4096);
  d.choice("activation", c.activation, kNetworkActivationWords,
           "What its output is: logits (sigmoid: classes of their own, softmax: one of them), probabilities, logits of which the "
           "largest counts (argmax), or one label a pixel.");
  d.option("object", c.object, "Channels (labels) that mean the object; empty = none.");
  d.option("transparent", c.transparent, "Channels (labels) that mean glass; empty = none.");
  d.option("specular", c.specular, "Channels (labels) that mean what mirrors, glass included; empty = none.");
  d.option("ignore", c.ignore, "Channels (labels) that mean what no photo should be held to; empty = none.");
  d.option("threshold", c.threshold, "Probability from which on a pixel belongs; it is written as one half.").range(0.01, 0.99);
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
  const bool graded = config.activation != NetworkActivation::Labels && config.activation != NetworkActivation::Argmax;
  for (size_t i = 0; i < values.size(); ++i) {
    double v = belonging(out, i, config.activation, channels);
    if (graded) v = std::clamp(v < t ? v / t - 0.5 : (v - t) / (1 - t) + 0.5, 0.0, 1.0);
    values[i] = float(v);
  }
  return values;
}

std::shared_ptr<const NetworkMasks> network_masks(const NetworkMasksConfig& config, const MaskCapture& capture,
                                                  const std::filesystem::path& file, std::span<const MaskClass> classes,
                                                  const std::function<void(double)>& progress) {
  auto masks = std::make_shared<NetworkMasks>();
  masks->config = config;
  PhotoNetwork network(read_file(file), {.where = file.string(),
                                         .input = config.input,
                                         .options = "masks.onnx",
                                         .instead = "give what it finds as files (--masks DIR)",
                                         .unlike = fmt::format("the network's output is no picture of {} channel{}",
                                                               config.outputs, config.outputs == 1 ? "" : "s"),
                                         .shape_hint = "its first output must be 1 x masks.onnx.outputs x h x w",
                                         .fits = [&](int channels) { return channels == config.outputs; }});
  masks->sha256 = network.sha256();
  for (MaskClass kind : classes) masks->classes[size_t(kind)].requested = true;
  const std::vector<View>& views = capture.set.views;
  for (size_t v = 0; v < views.size(); ++v) {
    throw_if_interrupted();
    const auto [w, h] = config.input.size_of(views[v].intrinsics.width, views[v].intrinsics.height);
    const NetworkOutput out = network.run(photo_of(capture, views[v], w, h));
    masks->views.push_back(views[v]);
    masks->views[v].intrinsics = views[v].intrinsics.scaled_to(out.width, out.height);
    for (MaskClass kind : classes) {
      NetworkMasks::Class& c = masks->classes[size_t(kind)];
      c.value.push_back(class_values(out, config, config.channels_of(kind), file.string()));
      c.found |= std::any_of(c.value[v].begin(), c.value[v].end(), [](float value) { return value >= 0.5f; });
    }
    progress(kNetworkShare * double(v + 1) / double(views.size()));
  }
  for (MaskClass kind : classes) {
    NetworkMasks::Class& c = masks->classes[size_t(kind)];
    // Passers-by move between photos, so no vote.
    if (!c.found || kind == MaskClass::Ignore || views.size() < kFewestVoters) continue;
    vote(*masks, c);
    log_info("masks: {}: photos and their hull overlap by {:.2f}{}", name(kind), c.agreement,
             c.voted ? "" : ", too little for a vote");
  }
  progress(1);
  return masks;
}

std::optional<SoftMask> NetworkSource::at(size_t view) const {
  const NetworkMasks::Class& c = masks_->classes[size_t(kind_)];
  if (!c.found) return std::nullopt;
  const Intrinsics& k = masks_->views[view].intrinsics;
  SoftMask soft{.value = ImageF(k.width, k.height, 1), .confidence = ImageF(k.width, k.height, 1)};
  std::copy(c.value[view].begin(), c.value[view].end(), soft.value.data().begin());
  for (size_t i = 0; i < c.value[view].size(); ++i) {
    const bool doubted = c.voted && c.doubted[view][i] != 0;
    const float sure = doubted ? kOverruled : std::abs(2 * c.value[view][i] - 1);
    soft.confidence.data()[i] = kNetworkConfidence * sure;
  }
  return soft;
}

void NetworkSource::report(nlohmann::ordered_json& j) const {
  const NetworkMasks::Class& c = masks_->classes[size_t(kind_)];
  j["network"] = {{"sha256", masks_->sha256},
                  {"channels", masks_->config.channels_of(kind_)},
                  {"activation", kNetworkActivationWords[size_t(masks_->config.activation)]},
                  {"threshold", masks_->config.threshold}};
  j["found"] = c.found;
  j["voted"] = c.voted;
  j["agreement"] = c.agreement;
}

}  // namespace vitrine
