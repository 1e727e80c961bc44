#include "stages/masks/onnx/network_source.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/base/json.h"
#include "core/base/log.h"
#include "core/base/process.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"
#include "core/image/resample.h"
#include "core/stereo/visual_hull.h"

namespace vitrine {

namespace {

constexpr double kNetworkShare = 0.8;    // of the work
constexpr double kLeastAgreement = 0.3;  // a hull that has less to do with the photos' masks than this decides nothing
constexpr float kOverruled = 0.3f;       // confidence where photo and hull disagree
constexpr size_t kFewestVoters = 4;

// The photo as the network wants it, and its camera at that size.
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

// What is left of a mask that an eraser of 2 radius + 1 pixels cannot wipe out: morphological opening.
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

// Lets the photos vote on one class.
void vote(NetworkMasks& masks, NetworkMasks::Class& c) {
  std::vector<Silhouette> photos;
  std::vector<std::vector<uint8_t>> own;
  for (size_t v = 0; v < masks.views.size(); ++v) {
    own.push_back(inside_of(c.value[v]));
    photos.push_back(silhouette(masks.views[v], own[v]));
  }
  const VisualHull hull(photos, {.resolution = masks.config.resolution, .rule = kOutlineVote});
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
    // An outline is the photo's own: the hull's is no finer than its voxels.
    const Intrinsics& k = masks.views[v].intrinsics;
    c.doubted.push_back(opened(apart, k, std::max(1, k.longest_side() / masks.config.resolution)));
    for (size_t i = 0; i < apart.size(); ++i)
      if (c.doubted[v][i]) c.value[v][i] = carried[v][i];
  }
}

}  // namespace

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
  for (MaskClass kind : classes) masks->classes[size_t(kind)].asked = true;
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
    // Who walks through the photos is in another place in each.
    if (!config.vote || !c.found || kind == MaskClass::Ignore || views.size() < kFewestVoters) continue;
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
    soft.confidence.data()[i] = float(masks_->config.confidence) * sure;
  }
  return soft;
}

void NetworkSource::report(nlohmann::ordered_json& j) const {
  const NetworkMasks::Class& c = masks_->classes[size_t(kind_)];
  j["network"] = {{"sha256", masks_->sha256},
                  {"channels", masks_->config.channels_of(kind_)},
                  {"activation", masks_->config.activation},
                  {"threshold", masks_->config.threshold}};
  j["found"] = c.found;
  j["voted"] = c.voted;
  j["agreement"] = c.agreement;
}

}  // namespace vitrine
