// Image quality in the conventions of the field: sRGB values in [0,1]; PSNR of the mean squared error over pixels and
// channels; SSIM with an 11x11 Gaussian window of sigma 1.5 (Wang et al. 2004), per channel, then averaged.
#pragma once

#include "core/image/image.h"

namespace vitrine {

// `mask` (one channel, weights in [0,1]) may be null. Returns NaN when no pixel counts, 99 when the images are equal.
double psnr(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);
double ssim(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);

}  // namespace vitrine
