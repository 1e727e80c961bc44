// Output files of the stage in addition to the surfels: held-out photos, training report, preview pictures.
#pragma once

#include <filesystem>
#include <map>
#include <span>
#include <vector>

#include "core/foundation/base/json.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"
#include "core/render/model/image_options.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/trainer.h"

namespace vitrine {

void write_views(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, bool object_alone);
// Photo, picture and normals of one photo side by side; below, the contribution of each layer.
void write_preview(const std::filesystem::path& path, const Trainer& trainer, const Capture& capture, uint32_t photo);
// The same of a rendered frame, without the layers; `photo`: planar [3,h,w], display-referred.
void write_preview(const std::filesystem::path& path, const Frame& frame, std::span<const float> photo);

struct PhotoQuality {
  uint32_t photo;
  double psnr;
};
// PSNR of every held-out photo at full training size, inside the object masks if there are any.
std::vector<PhotoQuality> measure(const Trainer& trainer, const Capture& capture, const Targets& targets);

// Writes the masks used to train an object with part of its surroundings, at photo size: masks/object/*.png in `folder`.
void write_trained_masks(const std::filesystem::path& folder, const Capture& capture, const Targets& targets);

// PSNR of a rendered frame, dB; at most 99. `photo`: planar [3,h,w], display-referred.
double frame_psnr(const Frame& frame, std::span<const float> photo);
double mean_psnr(std::span<const PhotoQuality> photos);  // dB; 0 without a photo

void write_report(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, const Trainer& trainer,
                  std::span<const PhotoQuality> heldout);

// The same for a capture that was trained in blocks (blocks.h).
struct BlocksReport {
  const OptimizeConfig& config;
  const Capture& cameras;
  std::vector<nlohmann::ordered_json> blocks = {};
  size_t surfels = 0, unseen = 0;
  std::vector<PhotoQuality> heldout = {};
};
void write_report(const std::filesystem::path& path, const BlocksReport& report);

// Opaque twin of a scene with glass or mirrors (core/render/model/opaque_pass.h), and the per-object share of the layers in the
// blended picture. Specular pixels of some training photos are withheld from both trainings as validation pixels.

// Share of the layers outside known shapes, where both scenes have the same kind of surfels.
inline constexpr float kLayeredElsewhere = 0.5f;

// [photo] 1: validation photo.
std::vector<uint8_t> judging_photos(const Capture& capture);

// Share of the layers in the picture, by object id: the share whose blend of both pictures, in linear light, is nearest (as
// displayed) to the withheld pixels of the validation photos; 0.5 for objects with too few pixels. `options`: of the scene's
// pictures, with all shares 1.
std::map<uint16_t, double> layered_shares(const SplatScene& scene, const ImageOptions& options, const Capture& capture,
                                          const Targets& targets, std::span<const uint8_t> judges);

}  // namespace vitrine
