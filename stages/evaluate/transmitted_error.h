// What our rays found behind the glass against the truth's picture of the scene without its glass: PSNR of sRGB values clipped to
// [0,1], over the pixels of the transparent mask, at the coarser of the two resolutions.
#pragma once

#include <optional>

#include "core/camera/view.h"
#include "core/image/image.h"
#include "stages/evaluate/truth.h"

namespace vitrine {

struct TransmittedPicture {
  const Intrinsics& intrinsics;
  const ImageF& radiance;  // linear, before the gain
  const Vec3d& gain;       // of the view: the truth's pictures are exposed like the photos
  const ImageF& mask;      // 0 or 1
};
// nullopt: fewer than `min_pixels` pixels of the mask lie in the truth's picture.
std::optional<double> transmitted_psnr(const TransmittedPicture& ours, const TruthPicture& truth, int min_pixels);

}  // namespace vitrine
