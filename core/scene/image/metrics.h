// Image quality metrics on sRGB values in [0,1]: PSNR of the mean squared error over pixels and channels; SSIM with an 11x11
// Gaussian window of sigma 1.5 (Wang et al. 2004), per channel, then averaged; FLIP.
#pragma once

#include <optional>

#include "core/scene/image/image.h"

namespace vitrine {

// Sums over pixels and channels; can be accumulated over several images.
struct SquaredError {
  double sum = 0, weight = 0;
  SquaredError& operator+=(const SquaredError& other);
  double psnr() const;  // dB; NaN if no pixel counts, capped at 99
};
// `mask` (one channel, weights in [0,1]) may be null.
SquaredError squared_error(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);

// Local correlation in 7x7 windows of the channel mean: sum of covariances / sqrt(product of the sums of variances). 1: same
// structure, 0: none in common. PSNR would prefer a blur to a sharp reflection that is displaced by one pixel.
struct LocalCorrelation {
  double covariance = 0, variance = 0, reference_variance = 0;  // sums over windows
  LocalCorrelation& operator+=(const LocalCorrelation& other);
  std::optional<double> value() const;  // nullopt: no window has variance in both images
};
// Uses windows that are fully inside the mask (weight 1) and have variance in at least one image; `mask` may be null.
LocalCorrelation local_correlation(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);

// `mask` (one channel, weights in [0,1]) may be null. Returns NaN if no pixel counts, 99 if the images are equal.
double psnr(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);
double ssim(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr);

// LDR-FLIP, the difference that a person sees who flips between two pictures (Andersson, Nilsson, Akenine-Moller, Oskarsson,
// Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating Images", HPG 2020). 0 = no difference, 1 = the largest.
// Colours are filtered with the contrast sensitivity of the eye and compared in Hunt-adjusted CIELAB by the HyAB distance; edges
// and points that only one picture has raise the difference. Algorithms 8.1.

// Pixels per degree of vision that the paper assumes: a display 0.7 m wide of 3840 pixels, seen from 0.7 m.
inline constexpr double kFlipPixelsPerDegree = 67.0206;

// Difference per pixel (one channel, in [0, 1]) of two sRGB pictures of three channels in [0, 1]. Edges are replicated.
ImageF flip_map(const ImageF& srgb, const ImageF& reference_srgb, double pixels_per_degree = kFlipPixelsPerDegree);

// Mean of flip_map. `mask` (one channel, weights in [0,1]) may be null. NaN if no pixel counts.
double flip(const ImageF& srgb, const ImageF& reference_srgb, const ImageF* mask = nullptr,
            double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace vitrine
