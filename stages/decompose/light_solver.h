// Albedo and light by turns (algorithms 7.3):
//   (a) light fixed:  rho_s = pi C_s / E_s, then averaged (in logarithms) over the points that probably have the same albedo
//   (b) rho fixed:    min over L >= 0 of  mean_s (1 - rho_s E_s(L) / (pi C_s))^2 + ridge |L - L_0|^2 + smooth |neighbours'
//   difference|^2
//       per channel: relative errors, so that dark points count as much as bright ones; coordinate descent on the normal matrix
//   (c) the scale of the light, which (a) and (b) leave open but for what the bounced light says: a convention. The mean open
//   light
//       is white, and the brightest twentieth of the surface has the albedo `white`.
#pragma once

#include <span>
#include <vector>

#include "core/scene/image/image.h"
#include "stages/decompose/affinity.h"
#include "stages/decompose/transport.h"

namespace vitrine {

struct LightSolverDesc {
  int rounds = 20;
  float white = 0.8f;
};

struct LightProblem {
  const Transport& transport;
  std::span<const LitPoint> points;  // all; only `chosen` take part
  std::span<const uint32_t> chosen;
  const Affinity& affinity;  // over `chosen`, by position in it
};

struct LightSolution {
  std::vector<Vec3f> light;       // [cells]; zero where no point looks
  std::vector<bool> free;         // [cells] that were solved for
  std::vector<double> misfit;     // per round: rms of log rho - log of its average
  double known_share = 0;         // of the irradiance, mean over the points: light that was not solved for
  bool scale_by_bounces = false;  // the wanted albedo is out of reach: even without open light surfaces would be darker
};

LightSolution solve_light(const LightProblem& problem, const LightSolverDesc& desc);

float luminance(const Vec3f& rgb);

// The light that was found, as a lat-long map (core/scene/light/environment.h).

// Seen walls and sky as they are, divided by `unit`; the rest as solved, and in its mean where no point told it. [height, 2
// height]
ImageF environment_map(const Surroundings& around, const LightGrid& grid, const LightSolution& solution, const Vec3f& unit);

}  // namespace vitrine
