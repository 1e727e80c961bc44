// Exposure and white balance of every photo, from the colours that the photos give to the same scene points: the linear photo
// is gain * radiance, so for view v, point k and each channel
//
//   log(observed_vk) = log(gain_v) + log(colour_k)
//
// minimised over all gains and colours under a robust loss (highlights, occlusions and wrong matches are outliers), with a weak
// pull of every log(gain) towards 0, and mean over views of log(gain) = 0.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/camera/colmap_model.h"
#include "core/camera/scene_info.h"
#include "core/image/image.h"

namespace vitrine {

struct GainSample {
  uint32_t view = 0, point = 0;
  Vec3f linear_rgb;
};

struct GainSettings {
  // Outside these values a channel says nothing about the ratio of two photos: clipped, or mostly noise and rounding.
  float darkest = 0.01f, brightest = 0.98f;
  size_t min_samples = 30;   // per view and channel; fewer = gain 1
  size_t max_points = 8000;  // the longest tracks are enough
  // Measured gains this small are the scene's (highlights move with the camera), not the camera's: exposure steps are a third
  // of a stop. Below both, for all views and channels, the capture counts as one of fixed exposure.
  double fixed_deviation = 0.02;  // standard deviation over views of log(gain)
  double fixed_largest = 0.05;    // largest |log(gain)|
  double prior_sigma = 1.0;       // of log(gain): photos of one capture stay within a few stops
};

struct GainSolution {
  std::vector<Vec3d> gains;            // [views], geometric mean over views = 1 per channel
  std::vector<uint32_t> undetermined;  // views with a channel of too few samples, whose gain was left at 1
  bool fixed_exposure = false;         // all gains are 1
  size_t samples = 0;                  // used, per channel, summed
  double spread = 0;                   // robust standard deviation of log(observed / predicted), worst channel
};

// Same result for any number of threads and any order of `samples` of equal view and point.
GainSolution solve_gains(size_t view_count, size_t point_count, std::span<const GainSample> samples,
                         const GainSettings& settings = {});

// Mean linear colour of the square of 2 radius + 1 pixels around (x, y); false when it leaves the photo or holds a value that
// is not finite.
bool sample_colour(const ImageF& linear, double x, double y, int radius, Vec3f& colour);
// The colours of all track observations; views are positions in model.images, points positions in model.points. 2D points are
// in pixels of what `linear_photo` returns.
std::vector<GainSample> track_samples(const ColmapModel& model, const std::function<ImageF(const ColmapImage&)>& linear_photo);

}  // namespace vitrine
