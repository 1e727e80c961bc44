// Output files of the stage in addition to the surfels: held-out photos, training report, preview pictures.
#pragma once

#include <filesystem>

#include "stages/optimize/trainer.h"

namespace vitrine {

void write_views(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, bool object_alone);
// Photo, picture and normals of one photo side by side; below, the contribution of each layer.
void write_preview(const std::filesystem::path& path, const Trainer& trainer, const Capture& capture, uint32_t photo);

struct PhotoQuality {
  uint32_t photo;
  double psnr;
};
// PSNR of every held-out photo at full training size, inside the object masks if there are any.
std::vector<PhotoQuality> measure(const Trainer& trainer, const Capture& capture, const Targets& targets);

// Writes the masks used to train an object with part of its surroundings, at photo size: masks/object/*.png in `folder`.
void write_trained_masks(const std::filesystem::path& folder, const Capture& capture, const Targets& targets);

double mean_psnr(std::span<const PhotoQuality> photos);  // dB; 0 without a photo

void write_report(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, const Trainer& trainer,
                  std::span<const PhotoQuality> heldout);

}  // namespace vitrine
