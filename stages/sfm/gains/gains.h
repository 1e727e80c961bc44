// Exposure and white balance of every photo, from the colours that the photos give to the same scene points: the linear photo
// is gain * radiance, so for view v, point k and channel c
//
//   log(observed_vkc) = log(gain_vc) + log(colour_kc)
//
// minimised over gains and colours under a robust loss (highlights, occlusions and wrong matches are outliers) and a prior: the
// exposure (mean over channels of log(gain)) is that of EXIF, or the same for all photos; the white balance (what the channels
// differ from it) is neutral. The mean over views of log(gain) is 0.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct GainSample {
  uint32_t view = 0, point = 0;
  Vec3f linear_rgb;
};

struct GainSettings {
  // Outside these values a channel says nothing about the ratio of two photos: clipped, or mostly noise and rounding.
  float darkest = 0.01f, brightest = 0.98f;
  size_t min_samples = 30;   // per view and channel; of fewer nothing is learnt
  size_t max_points = 8000;  // the longest tracks are enough
  // Measured gains this small are the scene's (highlights move with the camera), not the camera's: exposure steps are a third
  // of a stop. Below both, for all views and channels, the capture counts as one of fixed exposure.
  double fixed_deviation = 0.02;  // standard deviation over views of log(gain)
  double fixed_largest = 0.05;    // largest |log(gain)|
  // Standard deviations of the prior. Beyond those of log(gain) its cost grows linearly (Huber), so that gains of stops are
  // possible where the colours show them; and it is widened for a capture whose photos differ by more.
  double exposure_sigma = 0.1;  // a seventh of a stop
  double balance_sigma = 0.05;
  // Shading and highlights change many samples of a photo together: all samples of a photo and channel weigh at most as much as
  // this number of independent ones.
  double independent_samples = 10;
};

struct GainSolution {
  std::vector<Vec3d> gains;            // [views], geometric mean over views = 1 per channel
  std::vector<uint32_t> undetermined;  // views with a channel of too few samples, whose gain there is the prior's
  bool fixed_exposure = false;         // all gains are 1
  size_t samples = 0;                  // used, per channel, summed
  double spread = 0;                   // robust standard deviation of log(observed / predicted), worst channel
};

// `log_exposures` [views]: log(gain) according to EXIF, up to a constant; nullopt: not known for this photo. Empty: for none.
// Same result for any number of threads and any order of `samples` of equal view and point.
GainSolution solve_gains(size_t view_count, size_t point_count, std::span<const GainSample> samples,
                         const GainSettings& settings = {}, std::span<const std::optional<double>> log_exposures = {});

// Mean linear colour of the square of 2 radius + 1 pixels around (x, y); false when it leaves the photo or holds a value that
// is not finite or clipped.
bool sample_colour(const ImageF& linear, double x, double y, int radius, Vec3f& colour);
// The colours of all track observations; views are positions in model.images, points positions in model.points. 2D points are
// in pixels of what `linear_photo` returns.
std::vector<GainSample> track_samples(const ColmapModel& model, const std::function<ImageF(const ColmapImage&)>& linear_photo);

}  // namespace vitrine
