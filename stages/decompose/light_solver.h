// Alternating solver for albedo and light (algorithms 7.3):
//   (a) light fixed:  rho_s = pi C_s / E_s, then the mean of logarithms over points that probably have the same albedo
//   (b) rho fixed:    minimise over L >= 0, per channel, by coordinate descent on the normal matrix,
//                     mean_s (1 - rho_s E_s(L) / (pi C_s))^2 + ridge |L - L_0|^2 + smooth |L_j - L_k|^2 (neighbours j, k);
//                     the errors are relative, so dark points count as much as bright ones
//   (c) scale:        (a) and (b) determine it only through bounced light. Convention: the mean open light is white, and the
//                     brightest twentieth of the surface has the albedo `white`
#pragma once

#include <span>
#include <vector>

#include "core/scene/image/image.h"
#include "stages/decompose/lit_points.h"
#include "stages/decompose/transport.h"

namespace vitrine {

struct LightSolverDesc {
  int rounds = 20;
  float white = 0.8f;
};

struct LightProblem {
  const Transport& transport;
  std::span<const LitPoint> points;  // all; only `chosen` are used
  std::span<const uint32_t> chosen;
  const Affinity& affinity;  // over `chosen`, indexed by position in it
};

struct LightSolution {
  std::vector<Vec3f> light;       // [cells]; zero where no point receives light
  std::vector<bool> free;         // [cells] solved cells
  std::vector<double> misfit;     // per round: rms of log rho - log of its average
  double known_share = 0;         // share of known light in the irradiance, mean over the points
  bool scale_by_bounces = false;  // the wanted albedo is out of reach: surfaces are darker even without open light
};

LightSolution solve_light(const LightProblem& problem, const LightSolverDesc& desc);

float luminance(const Vec3f& rgb);

// The solved light as a lat-long map (core/scene/light/environment.h).

// Seen walls and sky, divided by `unit`; other directions as solved, or their mean where no point determines the light. [height,
// 2 height]
ImageF environment_map(const Surroundings& around, const LightGrid& grid, const LightSolution& solution, const Vec3f& unit);

}  // namespace vitrine
