// How well a scene shows photos: PSNR inside the glass, outside it, and of whole photos.
#pragma once

#include "core/render/picture/trained_scene.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

namespace vitrine {

struct Quality {
  double glass = 0, rest = 0, all = 0;  // dB, mean over the photos that have such pixels; 0 without any
};

// Photos at full size of the capture, and which of their pixels are glass: by their masks, else where the scene's surfels are
// transparent. Whatever becomes of the scene, the pixels stay the same; pixels that the masks say to ignore are not among them.
class QualityMeter {
 public:
  QualityMeter(const TrainedScene& scene, const Capture& capture, const Targets& targets, std::span<const uint32_t> photos);
  Quality of(const TrainedScene& scene) const;

 private:
  const Capture& capture_;
  std::vector<uint32_t> photos_;
  std::vector<std::vector<uint8_t>> glass_;    // [photo][h,w]
  std::vector<std::vector<uint8_t>> ignored_;  // [photo][h,w] or empty: pixels of 128 and more do not count
};

}  // namespace vitrine
