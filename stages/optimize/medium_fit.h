// Robust fit of water or haze before training (algorithms 5.11): a point of the scene, seen in several photos from different
// distances z, has the colours  I_i = J e^(-b_D z_i) + B (1 - e^(-b_B z_i)). J of each point and B follow in closed form from b_D
// and b_B (variable projection), which a grid and a pattern search find per channel. The darkest pixels of each distance limit B,
// which the colours alone determine badly: b_B and B compensate each other.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/medium_training.h"
#include "core/learn/trainer/targets.h"
#include "stages/optimize/initialise.h"
#include "stages/optimize/trainer.h"

namespace vitrine {

// One point in one photo.
struct MediumSample {
  uint32_t point, photo;
  float distance;  // scene units, along the ray
  Vec3f linear;    // before the gain; mean over the same part of the surface in all photos of the point
};

// Samples of up to a few thousand points, ascending by point: pixels with a reliable stereo depth in every photo that has the
// same surface there, and sparse points in the photos that see them. Clipped pixels, glass, mirrors and ignored pixels are left
// out, and points that are not seen from different distances.
std::vector<MediumSample> medium_samples(const Capture& capture, const Targets& targets, const DenseDepth& dense, uint64_t seed);

// What nearly all pixels of a range of distances exceed, per channel. Light that the medium scatters cannot be brighter:
// B (1 - e^(-b_B z)) <= linear.
struct DarkLevel {
  Vec3d distance, linear;  // of the pixel at the limit, along the ray and before the gain
};
// Of ranges of 10 % of the distance, from reliable pixels of dense stereo without glass, mirrors and ignored pixels.
std::vector<DarkLevel> dark_levels(const Capture& capture, const Targets& targets, const DenseDepth& dense);

struct MediumFit {
  MediumCoefficients<double> medium;
  size_t points = 0;
  // Share of the error of left-out photos that the medium explains: 1 - error / error of points with one colour each.
  double gain = 0;
  double depth = 0;  // largest of b_D z over the channels, z the median distance
};
inline constexpr size_t kFewestMediumPoints = 60;
// nullopt: fewer points.
std::optional<MediumFit> fitted_medium(std::span<const MediumSample> samples, MediumKind kind,
                                       std::span<const DarkLevel> dark = {});

// What training starts with, by the option; nullopt with `Off`.
struct ChosenMedium {
  std::optional<MediumStart> start;  // nullopt: none
  std::string why;                   // for the log, or the warning where a medium was wanted
};
std::optional<ChosenMedium> chosen_medium(WantedMedium wanted, const Capture& capture, const Targets& targets,
                                          const std::function<const DenseDepth&()>& depth, uint64_t seed);

}  // namespace vitrine
