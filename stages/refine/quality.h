// PSNR of a scene on photos: inside the glass, outside it, and overall.
#pragma once

#include "core/render/picture/trained_scene.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

namespace vitrine {

struct Quality {
  double glass = 0, rest = 0, all = 0;  // dB, mean over the photos with such pixels; 0 without any
};

// Photos at full capture size with their glass pixels: from the masks, else where the scene's surfels are transparent. The pixels
// stay fixed for all measured scenes; ignored pixels are excluded.
class QualityMeter {
 public:
  QualityMeter(const TrainedScene& scene, const Capture& capture, const Targets& targets, std::span<const uint32_t> photos);
  Quality of(const TrainedScene& scene) const;

 private:
  const Capture& capture_;
  std::vector<uint32_t> photos_;
  std::vector<std::vector<uint8_t>> glass_;    // [photo][h,w]
  std::vector<std::vector<uint8_t>> ignored_;  // [photo][h,w] or empty: values of 128 and more are ignored
};

}  // namespace vitrine
