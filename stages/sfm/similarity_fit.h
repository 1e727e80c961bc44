// Robust similarity between camera centres and positions in a local frame with z up (gps_frame.h).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/foundation/math/rigid.h"

namespace vitrine {

// Reach of a pair of unknown accuracy: three standard deviations of a receiver under open sky. Its heights are worse by a factor
// of two to three (GPS SPS Performance Standard, 2020).
inline constexpr double kReach_m = 5, kVerticalRatio = 3;

struct SpotPair {
  Vec3d from;  // camera centre in the frame of the model
  Vec3d to;    // east, north, up in metres
  bool height_known = true;
  double reach = kReach_m;  // metres: largest horizontal distance at which the pair agrees, three standard deviations
};

// The up vector of the model as an observation.
struct UpPrior {
  Vec3d direction;     // unit
  double sigma = 0.1;  // radians
};

bool agrees(const Similarity& s, const SpotPair& pair);

// Sum over the pairs of min(1, (h / reach)^2 + (v / (kVerticalRatio reach))^2), plus the squared deviation from the prior over
// (3 sigma)^2.
double truncated_cost(const Similarity& s, std::span<const SpotPair> pairs, const UpPrior& up);

// The similarity that takes `up` to +z and both pairs together horizontally; nullopt: they coincide there.
std::optional<Similarity> similarity_of_two(const SpotPair& a, const SpotPair& b, const Vec3d& up);
// Least squares (Umeyama 1991); nullopt: one spot or one line.
std::optional<Similarity> similarity_of_three(const SpotPair& a, const SpotPair& b, const SpotPair& c);

// Gauss-Newton steps over the pairs that agree, which are chosen again before each.
Similarity refined(const Similarity& start, std::span<const SpotPair> pairs, const UpPrior& up);

}  // namespace vitrine
