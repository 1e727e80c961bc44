// Densification and pruning of surfels during training (algorithms 2). Three strategies:
//   divide   transparent and idle surfels are relocated onto others, and the layer grows by a factor to a hard cap (after
//            Kheradmand et al. 2024); a copy and its parent become the two halves of the parent along its longer axis, opacity
//            kept: detail grows without the overdraw of coincident copies
//   classic  clones small and splits large surfels with a high screen-space gradient, removes faint ones, up to the same cap
//            (Kerbl et al. 2023, "3D Gaussian Splatting", section 5.2)
//   none     keeps the initial surfels
// Random numbers depend only on (seed, step, surfel).
#pragma once

#include <cstdint>
#include <vector>

#include "core/learn/optim/adam.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

enum class DensifyStrategy { Divide, Classic, None };
struct DensifyConfig {
  DensifyStrategy strategy = DensifyStrategy::Divide;
  int every = 50;                   // steps, rounded up to whole epochs
  double from = 0.05, until = 0.7;  // fractions of the run
  double growth = 1.1;              // of the number of surfels in `every` steps (divide)
  double idle_weight = 0.02;  // surfels whose sum of blending weights is below this fraction of the mean are relocated (divide)
  double split_size_rel = 0.01;  // larger surfels are split, smaller ones cloned, scene radii (classic)
};

// Sums of the surfel statistics since the last densification, and a running average that is kept.
struct SurfelAccumulator {
  std::vector<float> weight, error, screen_gradient;
  std::vector<uint32_t> seen;  // pictures in which the surfel had weight
  uint32_t pictures = 0;       // total number
  std::vector<float> share;    // running share of the pictures, over about a hundred, in which it had weight; inherited by copies

  void reset(size_t size);                         // resets the sums; new surfels get the mean share
  void keep_only(std::span<const uint32_t> kept);  // ascending; filters the running share, the sums must be reset
  // Visibility step scale: longer steps for surfels that few photos show, so that they converge in as many steps as the others:
  // mean share / own share, in [1, most].
  void rarity(float most, std::vector<float>& factor) const;
  void add(const SurfelStatistics& statistics);
  void transfer(Archive& archive);
};

struct DensifyTarget {
  SplatLayer& layer;
  Adam& adam;
  SurfelAccumulator& accumulator;  // reset to the new size afterwards
};
struct DensifyMoment {
  uint64_t seed = 0, step = 0;
  size_t cap = 0;  // maximum number of surfels in the layer
  int times = 1;   // number of densifications combined in this one: it grows by all of them
  double scene_radius = 1;
};
struct DensifyCounts {
  size_t relocated = 0, added = 0, removed = 0;
};

// Schedule of densification.
struct DensifyRhythm {
  uint64_t interval = 1;  // steps
  int times = 1;          // number of densifications combined in one
  uint64_t pictures = 0;  // number of pictures the sums must cover: a layer changed externally between two densifications
                          // starts over
};
// Every `every` steps, rounded up to whole epochs, so that every photo contributes to the decision which surfels are idle: a
// surfel visible in a single photo would otherwise be relocated whenever that photo was not used. If an epoch does not fit into
// the `window` (steps from `from` until `until`), every `every` steps nevertheless: too few surfels are worse.
DensifyRhythm densify_rhythm(const DensifyConfig& config, size_t photos, double window);

// Applies the strategy of `config`. The caller decides when (densify_rhythm, from, until).
DensifyCounts densify(const DensifyConfig& config, const DensifyMoment& moment, DensifyTarget target);

// mu += S xi * sigmoid(100 (0.005 - o)) * strength, with S = s_u^2 r0 r0^T + s_v^2 r1 r1^T: random walk of nearly transparent
// surfels.
void add_position_noise(SplatLayer& layer, float strength, uint64_t seed, uint64_t step);

}  // namespace vitrine
