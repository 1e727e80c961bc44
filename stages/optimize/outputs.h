// What the stage leaves behind beside the surfels: which photos were held out, how training went, preview pictures.
#pragma once

#include <filesystem>

#include "stages/optimize/trainer.h"

namespace vitrine {

void write_views(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, bool object_alone);
// Photo, picture and normals of one photo side by side; below, what each layer adds to the picture.
void write_preview(const std::filesystem::path& path, const Trainer& trainer, const Capture& capture, uint32_t photo);

struct PhotoQuality {
  uint32_t photo;
  double psnr;
};
// Every held-out photo against its picture, full training size, inside the object's masks where there are any.
std::vector<PhotoQuality> measure(const Trainer& trainer, const Capture& capture, const Targets& targets);

// The masks inside which an object and a part of its surroundings were trained, of the photos' sizes: masks/object/*.png in
// `folder`.
void write_trained_masks(const std::filesystem::path& folder, const Capture& capture, const Targets& targets);

double mean_psnr(std::span<const PhotoQuality> photos);  // dB; 0 without a photo

void write_report(const std::filesystem::path& path, const OptimizeConfig& config, const Capture& capture, const Trainer& trainer,
                  std::span<const PhotoQuality> heldout);

}  // namespace vitrine
