// Image quality in the conventions of the field: sRGB values in [0,1]; PSNR of the mean squared error over pixels and
// channels; SSIM with an 11x11 Gaussian window of sigma 1.5 (Wang et al. 2004), per channel, then averaged.
#pragma once

#include <optional>

#include "core/scene/image/image.h"

namespace vitrine {

// Sums over pixels and channels, so that the pixels of several pictures can be pooled.
struct SquaredError {
  double sum = 0, weight = 0;
  SquaredError& operator+=(const SquaredError& other);
  double psnr() const;  // dB; NaN where no pixel counts, 99 at most
};
// `mask` (one channel, weights in [0,1]) may be null.
SquaredError squared_error(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);

// How far two pictures vary alike within 7x7 windows: sum of covariances / sqrt(product of the sums of variances), of the mean of
// the channels. 1: the same structure, 0: none in common, where PSNR prefers a blur to a sharp reflection that is one pixel off.
struct LocalCorrelation {
  double covariance = 0, variance = 0, reference_variance = 0;  // sums over windows
  LocalCorrelation& operator+=(const LocalCorrelation& other);
  std::optional<double> value() const;  // nullopt: no window varies in both
};
// Of the windows that lie in the mask (pixels of weight 1) as a whole and vary in one of the two; `mask` may be null.
LocalCorrelation local_correlation(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);

// `mask` (one channel, weights in [0,1]) may be null. Returns NaN when no pixel counts, 99 when the images are equal.
double psnr(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);
double ssim(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);

}  // namespace vitrine
