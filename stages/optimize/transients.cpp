#include "stages/optimize/transients.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/render/model/layered_model.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/contact_sheet.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

constexpr int kScoutSteps = 300, kScoutPasses = 8;  // of the short training, whichever is longer; at most half of the whole one
constexpr int kScoutSurfels = 30000, kScoutFirst = 20000;
constexpr double kScoutSide = 280;     // pixels, longest side of the photos, about
constexpr float kShowsSurface = 0.5f;  // alpha above which a pixel has a depth
constexpr uint8_t kSoftMask = 16;      // of masks of glass and mirrors
constexpr int kSheetColumns = 4, kSheetWidth = 320;

size_t scout_level(const Capture& capture) {
  size_t best = 0;
  double least = 1e300;
  for (size_t l = 0; l < kLevels; ++l) {
    const double side = capture.photos[capture.train.front()].levels[l].view.intrinsics.longest_side();
    if (const double off = std::abs(std::log(side / kScoutSide)); off < least) least = off, best = l;
  }
  return best;
}

std::vector<uint8_t> specular_pixels(const TargetLevel& target, size_t pixels) {
  std::vector<uint8_t> excluded;
  for (const std::vector<uint8_t>* mask :
       {&target.masks[size_t(MaskClass::Specular)], &target.masks[size_t(MaskClass::Transparent)], &target.coat}) {
    if (mask->empty()) continue;
    excluded.resize(pixels, 0);
    for (size_t i = 0; i < pixels; ++i) excluded[i] |= (*mask)[i] >= kSoftMask;
  }
  return excluded;
}

TransientPhoto photographed(const LayeredModel& model, const SplatScene& scene, const PhotoLevel& level,
                            const TargetLevel& target) {
  TransientPhoto photo{.view = level.view, .photo = {}, .picture = {}, .zdepth = {}, .excluded = {}};
  Frame frame;
  frame.differentiable = false;
  model.forward(scene, photo.view, frame);
  decode(level, photo.photo);
  photo.picture = frame.srgb;
  const size_t pixels = frame.pixel_count();
  const auto z = frame.diffuse.plane(Aov::ZDepth), alpha = frame.diffuse.plane(Aov::Alpha),
             median = frame.diffuse.plane(Aov::MedianZ);
  photo.zdepth.assign(pixels, 0.f);
  for (size_t i = 0; i < pixels; ++i)
    if (alpha[i] > kShowsSurface) photo.zdepth[i] = surface_depth(z[i], alpha[i], median[i]);
  photo.excluded = specular_pixels(target, pixels);
  return photo;
}

// Nearest pixels of a mask at another size.
std::vector<uint8_t> scaled(std::span<const uint8_t> mask, const Intrinsics& from, const Intrinsics& to) {
  std::vector<uint8_t> result(to.pixel_count());
  for (int y = 0; y < to.height; ++y)
    for (int x = 0; x < to.width; ++x)
      result[to.index(x, y)] = mask[from.index(x * from.width / to.width, y * from.height / to.height)];
  return result;
}

Image8 with_mask(const PhotoLevel& photo, std::span<const uint8_t> mask) {
  const Intrinsics& k = photo.view.intrinsics;
  Image8 picture(k.width, k.height, 3);
  std::vector<float> srgb;
  decode(photo, srgb);
  for (size_t i = 0; i < k.pixel_count(); ++i)
    for (size_t c = 0; c < 3; ++c) {
      const float value = 255 * srgb[c * k.pixel_count() + i];
      picture.data()[3 * i + c] = uint8_t(std::lround(mask[i] ? 0.5f * value + (c == 0 ? 127.f : 0.f) : value));
    }
  return picture;
}

}  // namespace

void configure_scout(const OptimizeConfig& config, const Capture& capture, OptimizeConfig& scout) {
  scout.iterations =
      std::max(1, std::min(config.iterations / 2, std::max(kScoutSteps, kScoutPasses * int(capture.train.size()))));
  scout.max_gaussians = std::min(config.max_gaussians, kScoutSurfels);
  scout.initial.frustum_points = std::min({config.initial.frustum_points, kScoutFirst, scout.max_gaussians});
  scout.layers = WantedLayers::Diffuse;
  scout.densify.strategy = DensifyStrategy::None;  // copies of surfels near the camera would explain the transient content
  scout.sh_degree = 0;
  scout.fill_unseen = false;
  scout.max_side = config.max_side, scout.backend = config.backend, scout.seed = config.seed;
  scout.checkpoint_every = config.checkpoint_every;
  scout.rates = config.rates;
  const size_t level = scout_level(capture);
  if (level == 2) scout.resolution.quarter_until = 2;
  if (level == 1) scout.resolution.half_until = 2;
}

Transients found_transients(const Trainer& scout, const Capture& capture, const Targets& targets) {
  Transients found{.level = scout_level(capture), .masks = std::vector<std::vector<uint8_t>>(capture.photos.size())};
  const LayeredModel model(scout.image_options());
  std::vector<TransientPhoto> photos;
  for (const uint32_t v : capture.train) {
    throw_if_interrupted();
    photos.push_back(photographed(model, scout.scene(), capture.photos[v].levels[found.level], targets.photos[v][found.level]));
  }
  const std::vector<TransientEvidence> evidence = transient_evidence(photos);
  parallel_for(photos.size(), 1, [&](size_t t) {
    const Intrinsics& k = photos[t].view.intrinsics;
    found.masks[capture.train[t]] = transient_regions(evidence[t], photos[t].excluded, k.width, k.height);
  });
  double marked = 0, all = 0;
  for (const std::vector<uint8_t>& mask : found.masks) {
    found.photos += !mask.empty();
    all += double(mask.size()), marked += double(std::ranges::count(mask, 255));
  }
  found.share = all > 0 ? marked / all : 0;
  return found;
}

void ignore_transients(const Transients& transients, Targets& targets, const Capture& capture) {
  for (size_t v = 0; v < transients.masks.size(); ++v) {
    if (transients.masks[v].empty()) continue;
    targets.has[size_t(MaskClass::Ignore)] = true;
    const Intrinsics& from = capture.photos[v].levels[transients.level].view.intrinsics;
    for (size_t l = 0; l < kLevels; ++l) {
      const std::vector<uint8_t> mask = scaled(transients.masks[v], from, capture.photos[v].levels[l].view.intrinsics);
      std::vector<uint8_t>& ignore = targets.photos[v][l].masks[size_t(MaskClass::Ignore)];
      targets.memory_bytes += ignore.empty() ? mask.size() : 0;
      ignore.resize(mask.size(), 0);
      std::ranges::transform(ignore, mask, ignore.begin(), [](uint8_t a, uint8_t b) { return std::max(a, b); });
    }
  }
}

void write_transients(const std::filesystem::path& folder, const Transients& transients, const Capture& capture) {
  ContactSheet sheet(kSheetColumns, kSheetWidth);
  sheet.start_row("transient content, not trained on");
  for (size_t v = 0; v < transients.masks.size(); ++v) {
    if (transients.masks[v].empty()) continue;
    const View& view = capture.view_set.views[v];
    const PhotoLevel& level = capture.photos[v].levels[transients.level];
    const std::vector<uint8_t> mask = scaled(transients.masks[v], level.view.intrinsics, view.intrinsics);
    Image8 image(view.intrinsics.width, view.intrinsics.height, 1);
    std::ranges::copy(mask, image.data().begin());
    const std::filesystem::path path = view_mask_path(folder, MaskClass::Ignore, view);
    std::filesystem::create_directories(path.parent_path());
    write_ldr(path, image);
    sheet.add(view.name, with_mask(level, transients.masks[v]));
  }
  sheet.write(folder / "contact_sheet.png");
}

}  // namespace vitrine
