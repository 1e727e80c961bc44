#include "stages/refine/refine.h"

#include <array>
#include <cmath>

#include "core/foundation/base/process.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/surface_pass.h"
#include "core/render/picture/view_picture.h"
#include "core/scene/image/metrics.h"

namespace vitrine {

namespace {

constexpr double kFewestPixels = 64;  // of a region, as in the evaluation

}  // namespace

QualityMeter::QualityMeter(const TrainedScene& scene, const Capture& capture, const Targets& targets,
                           std::span<const uint32_t> photos)
    : capture_(capture), photos_(photos.begin(), photos.end()) {
  ImageModel model({.diffuse = scene.image.diffuse});
  model.options().diffuse.materials = true;
  model.emplace<DiffusePass>(scene.image.diffuse.backend);
  Frame frame;
  for (const uint32_t photo : photos_) {
    throw_if_interrupted();
    const std::vector<uint8_t>& mask = targets.photos[photo][0].masks[static_cast<size_t>(MaskClass::Transparent)];
    std::vector<uint8_t>& glass = glass_.emplace_back(capture.photos[photo].levels[0].srgb.size() / 3, 0);
    ignored_.push_back(targets.photos[photo][0].masks[static_cast<size_t>(MaskClass::Ignore)]);
    if (!mask.empty()) {
      for (size_t i = 0; i < glass.size(); ++i) glass[i] = mask[i] >= 128;
      continue;
    }
    model.forward(scene.surfels, capture.photos[photo].levels[0].view, frame);
    const auto tau = frame.diffuse.plane(Aov::Transmission);
    for (size_t i = 0; i < glass.size(); ++i) glass[i] = tau[i] > 0.5f;
  }
}

Quality QualityMeter::of(const TrainedScene& scene) const {
  ScenePainter painter(scene, {.medium = true});
  std::array<double, 3> sums{};
  std::array<size_t, 3> photos{};
  std::vector<float> target;
  for (size_t p = 0; p < photos_.size(); ++p) {
    throw_if_interrupted();
    const PhotoLevel& photo = capture_.photos[photos_[p]].levels[0];
    decode(photo, target);
    const ViewPicture picture = painter.picture(photo.view);
    const auto shown = picture.srgb.data();
    const size_t pixels = target.size() / 3;
    std::array<SquaredError, 3> error;  // glass, rest, all
    for (size_t i = 0; i < pixels; ++i) {
      if (!ignored_[p].empty() && ignored_[p][i] >= 128) continue;
      double e = 0;
      for (size_t c = 0; c < 3; ++c) {
        const double d = double(shown[3 * i + c]) - double(target[c * pixels + i]);
        e += d * d;
      }
      for (SquaredError* part : {&error[glass_[p][i] ? 0 : 1], &error[2]}) {
        part->sum += e;
        part->weight += 3;
      }
    }
    for (size_t part = 0; part < 3; ++part)
      if (error[part].weight >= 3 * kFewestPixels) {
        sums[part] += error[part].psnr();
        ++photos[part];
      }
  }
  const auto mean = [&](size_t part) { return photos[part] > 0 ? sums[part] / double(photos[part]) : 0; };
  return {.glass = mean(0), .rest = mean(1), .all = mean(2)};
}

}  // namespace vitrine
