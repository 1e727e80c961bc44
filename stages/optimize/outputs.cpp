#include "stages/optimize/outputs.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/foundation/base/file.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/color.h"
#include "core/scene/camera/view_masks.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

using Json = nlohmann::ordered_json;

// Six digits, which hides differences in the last bits.
double rounded(double value) { return std::isfinite(value) ? std::stod(fmt::format("{:.6g}", value)) : 0.0; }

uint8_t byte_of(float value) { return static_cast<uint8_t>(std::lround(255.f * std::clamp(value, 0.f, 1.f))); }

void write_frame(const std::filesystem::path& path, const Frame& frame, std::span<const float> target, bool layered) {
  const Intrinsics& k = frame.view->intrinsics;
  const size_t pixels = frame.pixel_count();
  const auto normal = frame.diffuse.plane(Aov::Normal);
  Image8 image(3 * k.width, (layered ? 2 : 1) * k.height, 3);
  const std::vector<float>* parts[] = {&frame.layers.diffuse, &frame.layers.reflection, &frame.layers.transmission};
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const size_t i = k.index(x, y);
      for (size_t c = 0; c < 3; ++c) {
        image.at(x, y, int(c)) = byte_of(target[c * pixels + i]);
        image.at(k.width + x, y, int(c)) = byte_of(frame.srgb[c * pixels + i]);
        image.at(2 * k.width + x, y, int(c)) = byte_of(0.5f + 0.5f * normal[c * pixels + i]);
        const auto gain = static_cast<float>(frame.view->gain[c]);
        for (int part = 0; layered && part < 3; ++part) {
          const std::vector<float>& radiance = *parts[part];
          if (!radiance.empty())
            image.at(part * k.width + x, k.height + y, int(c)) =
                byte_of(srgb_from_linear(std::clamp(gain * radiance[c * pixels + i], 0.f, 1.f)));
        }
      }
    }
  write_ldr(path, image);
}

}  // namespace

void write_views(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, bool object_alone) {
  Json json{{"holdout_every", config.holdout_every}, {"max_side", config.max_side}};
  if (object_alone) json["object_alone"] = true;
  json["train"] = Json::array();
  json["heldout"] = Json::array();
  for (uint32_t i : capture.train) json["train"].push_back(capture.view_set.views[i].name);
  for (uint32_t i : capture.heldout) json["heldout"].push_back(capture.view_set.views[i].name);
  write_file(path, json.dump(2) + "\n");
}

void write_preview(const std::filesystem::path& path, const Trainer& trainer, const Capture& capture, uint32_t photo) {
  Frame frame;
  const bool layered = trainer.layers().any();
  trainer.picture(photo, layered, frame);
  std::vector<float> target;
  decode(capture.photos[photo].levels[0], target);
  write_frame(path, frame, target, layered);
}

void write_preview(const std::filesystem::path& path, const Frame& frame, std::span<const float> photo) {
  write_frame(path, frame, photo, false);
}

double frame_psnr(const Frame& frame, std::span<const float> photo) {
  double sum = 0;
  for (size_t i = 0; i < photo.size(); ++i) sum += (double(frame.srgb[i]) - photo[i]) * (double(frame.srgb[i]) - photo[i]);
  return sum > 0 ? -10 * std::log10(sum / double(photo.size())) : 99;
}

std::vector<PhotoQuality> measure(const Trainer& trainer, const Capture& capture, const Targets& targets) {
  std::vector<PhotoQuality> result;
  Frame frame;
  std::vector<float> target;
  for (uint32_t photo : capture.heldout) {
    throw_if_interrupted();
    trainer.picture(photo, false, frame);
    decode(capture.photos[photo].levels[0], target);
    const size_t pixels = target.size() / 3;
    const auto& object = targets.photos[photo][0].masks[size_t(MaskClass::Object)];
    double sum = 0, count = 0;
    for (size_t i = 0; i < target.size(); ++i) {
      if (!object.empty() && object[i % pixels] < 128) continue;
      sum += (double(frame.srgb[i]) - target[i]) * (double(frame.srgb[i]) - target[i]);
      count += 1;
    }
    if (count > 0) result.push_back({photo, sum > 0 ? -10 * std::log10(sum / count) : 99});
  }
  return result;
}

double mean_psnr(std::span<const PhotoQuality> photos) {
  double sum = 0;
  for (const PhotoQuality& q : photos) sum += q.psnr;
  return photos.empty() ? 0 : sum / double(photos.size());
}

void write_trained_masks(const std::filesystem::path& folder, const Capture& capture, const Targets& targets) {
  make_folders(folder / "masks/object");
  parallel_for(capture.photos.size(), 1, [&](size_t i) {
    const View& view = capture.view_set.views[i];
    const Intrinsics& k = capture.photos[i].levels[0].view.intrinsics;
    const auto& trained = targets.photos[i][0].masks[size_t(MaskClass::Object)];
    ImageF mask(k.width, k.height, 1);
    for (size_t p = 0; p < trained.size(); ++p) mask.data()[p] = float(trained[p]) / 255.f;
    mask = resized(mask, view.intrinsics.width, view.intrinsics.height);
    Image8 image(mask.width(), mask.height(), 1);
    for (size_t p = 0; p < mask.pixel_count(); ++p) image.data()[p] = mask.data()[p] >= 0.5f ? 255 : 0;
    write_ldr(view_mask_path(folder, MaskClass::Object, view), image);
  });
}

namespace {

void add_heldout(const Capture& capture, std::span<const PhotoQuality> heldout, Json& json) {
  json["heldout"] = Json::array();
  for (const PhotoQuality& q : heldout)
    json["heldout"].push_back({{"name", capture.view_set.views[q.photo].name}, {"psnr", rounded(q.psnr)}});
  if (!heldout.empty()) json["heldout_psnr"] = rounded(mean_psnr(heldout));
}

Json poses_json(const Capture& capture, const Trainer& trainer) {
  Json json{{"corrected", trainer.corrects_poses()}};
  if (!trainer.corrects_poses()) return json;
  constexpr double kDegrees = 180 / std::numbers::pi;
  for (const auto& [name, photos] : {std::pair{"train", &capture.train}, std::pair{"heldout", &capture.heldout}}) {
    const PoseDistance d = trainer.poses().moved(*photos);
    json[name] = {{"turn_deg", rounded(kDegrees * d.turn_rad)},
                  {"largest_turn_deg", rounded(kDegrees * d.largest_turn_rad)},
                  {"shift", rounded(d.shift)},
                  {"largest_shift", rounded(d.largest_shift)}};
  }
  return json;
}

}  // namespace

void write_report(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, const Trainer& trainer,
                  std::span<const PhotoQuality> heldout) {
  Json json{{"iterations", trainer.step_index()},
            {"surfels", trainer.scene().diffuse.size()},
            {"initial_surfels", trainer.initial_surfels()},
            {"max_surfels", config.max_gaussians},
            {"unseen_surfels", trainer.unseen_surfels()},
            {"from_behind_glass", trainer.from_behind_glass()},
            {"sh_degree", config.sh_degree},
            {"train_photos", capture.train.size()},
            {"heldout_photos", capture.heldout.size()}};
  for (LayerKind kind : kAllLayers) {
    if (kind != LayerKind::Diffuse && !trainer.layers().has(kind)) continue;
    const TrainCounts& counts = trainer.counts(kind);
    json["layers"][std::string(name(kind))] = {{"surfels", trainer.scene().layer(kind).size()},
                                               {"max_surfels", trainer.cap(kind)},
                                               {"skipped_gradients", counts.skipped_gradients},
                                               {"relocated", counts.relocated},
                                               {"added", counts.added},
                                               {"removed", counts.removed}};
  }
  if (config.poses == WantedPoses::Auto) json["poses"] = poses_json(capture, trainer);
  if (trainer.scene().opaque.size() > 0) json["opaque_twin"] = {{"surfels", trainer.scene().opaque.size()}};
  json["epochs"] = Json::array();
  for (const EpochRecord& e : trainer.epochs())
    json["epochs"].push_back({{"step", e.step}, {"surfels", e.surfels}, {"loss", rounded(e.loss)}, {"l1", rounded(e.l1)}});
  add_heldout(capture, heldout, json);
  write_file(path, json.dump(2) + "\n");
}

void write_report(const std::filesystem::path& path, const BlocksReport& report) {
  const auto sum = [&](const char* what) {
    size_t all = 0;
    for (const Json& block : report.blocks) all += block.at(what).get<size_t>();
    return all;
  };
  Json json{{"iterations", sum("iterations")},
            {"surfels", report.surfels},
            {"initial_surfels", sum("initial_surfels")},
            {"max_surfels", report.config.max_gaussians},
            {"unseen_surfels", report.unseen},
            {"from_behind_glass", 0},
            {"sh_degree", report.config.sh_degree},
            {"train_photos", report.cameras.train.size()},
            {"heldout_photos", report.cameras.heldout.size()}};
  json["layers"]["diffuse"] = {{"surfels", report.surfels}, {"max_surfels", report.config.max_gaussians}};
  json["blocks"] = report.blocks;
  add_heldout(report.cameras, report.heldout, json);
  write_file(path, json.dump(2) + "\n");
}

}  // namespace vitrine
