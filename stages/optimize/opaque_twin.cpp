#include "stages/optimize/outputs.h"

#include <algorithm>
#include <array>

#include "core/foundation/base/log.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/color.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/opaque_pass.h"

namespace vitrine {

namespace {

constexpr size_t kJudgeEvery = 20, kFirstJudge = 4;  // of the training photos
constexpr size_t kFewestJudged = 200;                // pixels of an object
constexpr double kShareUnjudged = 0.5;               // share of an object with fewer pixels
constexpr size_t kShares = 20;                       // number of shares tried, in addition to 0

// [pixel] True for pixels withheld from both trainings: specular, transparent or coated, inside the object mask, and not ignored.
bool was_withheld(const TargetLevel& target, size_t pixel) {
  const auto has = [&](const std::vector<uint8_t>& mask, bool without) { return mask.empty() ? without : mask[pixel] >= 128; };
  const auto of = [&](MaskClass kind) -> const std::vector<uint8_t>& { return target.masks[size_t(kind)]; };
  return (has(of(MaskClass::Specular), false) || has(of(MaskClass::Transparent), false) || has(target.coat, false)) &&
         !has(of(MaskClass::Ignore), false) && has(of(MaskClass::Object), true);
}

struct Judged {
  std::array<double, kShares + 1> squared{};
  size_t pixels = 0;
};

}  // namespace

std::vector<uint8_t> judging_photos(const Capture& capture) {
  std::vector<uint8_t> judges(capture.photos.size(), 0);
  for (size_t i = kFirstJudge; i < capture.train.size(); i += kJudgeEvery) judges[capture.train[i]] = 1;
  return judges;
}

std::map<uint16_t, double> layered_shares(const SplatScene& scene, const ImageOptions& options, const Capture& capture,
                                          const Targets& targets, std::span<const uint8_t> judges) {
  const LayeredModel model(options);
  OpaquePicture twin(options.diffuse.backend);
  std::map<uint16_t, Judged> found;
  for (const ShapeSet::Entry& e : options.shape.set->entries) found[e.object];
  Frame frame;
  frame.differentiable = false;
  std::vector<float> photo;
  for (const uint32_t index : capture.train) {
    if (!judges[index]) continue;
    const PhotoLevel& level = capture.photos[index].levels[0];
    decode(level, photo);
    throw_if_interrupted();
    model.forward(scene, level.view, frame);
    const std::span<const float> opaque = twin.draw(scene, level.view, options);
    const std::vector<uint32_t> shown = shapes_shown(frame);
    for (size_t i = 0; i < shown.size(); ++i) {
      if (shown[i] == 0 || !was_withheld(targets.photos[index][0], i)) continue;
      Judged& judged = found[options.shape.set->entries[shown[i] - 1].object];
      ++judged.pixels;
      for (size_t c = 0; c < 3; ++c) {
        const size_t at = c * shown.size() + i;
        for (size_t s = 0; s <= kShares; ++s) {
          const double share = double(s) / double(kShares);
          const double light = level.view.gain[c] * (share * double(frame.linear[at]) + (1 - share) * double(opaque[at]));
          const double off = srgb_from_linear(std::clamp(light, 0.0, 1.0)) - double(photo[at]);
          judged.squared[s] += off * off;
        }
      }
    }
  }
  std::map<uint16_t, double> shares;
  for (const auto& [object, judged] : found) {
    const auto best = double(std::ranges::min_element(judged.squared) - judged.squared.begin()) / double(kShares);
    shares[object] = judged.pixels < kFewestJudged ? kShareUnjudged : best;
    log_info("object {}: {:.0f} % of its picture is that of the layers ({} pixels judged)", object, 100 * shares[object],
             judged.pixels);
  }
  return shares;
}

}  // namespace vitrine
