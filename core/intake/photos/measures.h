// Quality measures of a single photo: sharpness, texture, exposure. Pure functions of one 8-bit picture; `vitrine inspect`
// compares them within a set, and the sfm stage uses them when a photo has no pose.
//
// Blur (Zhuo and Sim 2011): an edge of height A blurred by a Gaussian of s has, after another smoothing by a, the slope
// A / sqrt(2 pi (s^2 + a^2)). With two smoothings a < b the ratio r of slopes gives
//   s^2 = (b^2 - r^2 a^2) / (r^2 - 1)
// at every edge, independent of its height. Medians are taken per gradient direction: motion blurs one direction only, defocus
// all.
#pragma once

#include <optional>
#include <vector>

#include "core/scene/image/image.h"

namespace vitrine {

struct PhotoMeasures {
  int width = 0, height = 0;             // of the measured picture
  std::optional<double> blur_px;         // s of the most blurred direction, in its pixels; empty: too few edges
  double blur_ratio = 1;                 // worst over best direction: far above 1 = motion blur
  double texture = 0;                    // share of 16 x 16 cells that contain a corner
  double clipped_high = 0;               // share of pixels with a saturated channel
  double clipped_low = 0;                // share of black pixels
  double brightness_ev = 0;              // log2 of the mean linear luminance
  double red_green = 0, blue_green = 0;  // log2 of ratios of mean linear channels, without clipped pixels
  std::vector<float> thumbnail;          // [32 * 32] grey, mean 0, mean square 1; empty when the picture is textureless
};

PhotoMeasures measured(const Image8& srgb);  // 3 channels

// Mean product of two thumbnails, in [-1, 1]; 0 when one is empty. Above kSamePicture: a duplicate.
double likeness(const PhotoMeasures& a, const PhotoMeasures& b);
inline constexpr double kSamePicture = 0.9985;

}  // namespace vitrine
