// Exposure and white balance of every photo, from the colours of the same scene points in several photos. The linear photo is
// gain * radiance, so for view v, point k and channel c
//
//   log(observed_vkc) = log(gain_vc) + log(colour_kc)
//
// minimised over gains and colours with a robust loss (highlights, occlusions and wrong matches are outliers) and a prior: the
// exposure (mean over channels of log(gain)) equals that of EXIF, or is the same for all photos; the white balance (deviation of
// the channels from the exposure) is neutral. The mean over views of log(gain) is 0.
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
  // Outside this range a sample is not used: it is clipped, or mostly noise and rounding.
  float darkest = 0.01f, brightest = 0.98f;
  size_t min_samples = 30;   // per view and channel; with fewer the gain is not estimated
  size_t max_points = 8000;  // points with the longest tracks
  // Gains below both limits in all views and channels are caused by the scene (view-dependent highlights), not by the camera,
  // whose smallest exposure step is a third of a stop: the capture counts as one of fixed exposure.
  double fixed_deviation = 0.02;  // standard deviation over views of log(gain)
  double fixed_largest = 0.05;    // largest |log(gain)|
  // Standard deviations of the prior. Beyond one sigma in log(gain) the cost grows linearly (Huber), so that the colours can
  // force gains of several stops. The prior is widened for a capture whose photos differ by more.
  double exposure_sigma = 0.1;  // a seventh of a stop
  double balance_sigma = 0.05;
  // Shading and highlights change many samples of a photo together: the total weight of all samples of a photo and channel is at
  // most that of this number of independent samples.
  double independent_samples = 10;
};

struct GainSolution {
  std::vector<Vec3d> gains;            // [views], geometric mean over views = 1 per channel
  std::vector<uint32_t> undetermined;  // views with a channel of too few samples; its gain there is that of the prior
  bool fixed_exposure = false;         // all gains are 1
  size_t samples = 0;                  // used samples, summed over channels
  double spread = 0;                   // robust standard deviation of log(observed / predicted), worst channel
};

// `log_exposures` [views]: log(gain) from EXIF, up to a constant; nullopt: not known for this photo; empty: not known for any.
// The result does not depend on the number of threads or the order of `samples` of equal view and point.
GainSolution solve_gains(size_t view_count, size_t point_count, std::span<const GainSample> samples,
                         const GainSettings& settings = {}, std::span<const std::optional<double>> log_exposures = {});

// Mean linear colour of the (2 radius + 1)^2 pixels around (x, y); false when the square leaves the photo or contains a
// non-finite or clipped value.
bool sample_colour(const ImageF& linear, double x, double y, int radius, Vec3f& colour);
// The colours of all track observations; views are positions in model.images, points positions in model.points. 2D points are
// in pixels of what `linear_photo` returns.
std::vector<GainSample> track_samples(const ColmapModel& model, const std::function<ImageF(const ColmapImage&)>& linear_photo);

}  // namespace vitrine
