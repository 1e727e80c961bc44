// Where surfels come from and go to while a layer is trained (algorithms 2). Three strategies:
//   divide   dead and idle surfels move onto living ones, and the layer grows by a factor to a hard cap (after Kheradmand et al.
//            2024); a copy and its parent become the two halves of the parent along its longer axis, opacity kept: detail grows
//            without the overdraw of coincident copies
//   classic  clone small and split large surfels whose screen-space gradient is high, drop faint ones, up to the same cap
//            (Kerbl et al. 2023, "3D Gaussian Splatting", section 5.2)
//   none     the initial surfels are all there is
// Random numbers depend on (seed, step, surfel) alone.
#pragma once

#include <cstdint>
#include <vector>

#include "core/learn/optim/adam.h"
#include "core/render/raster/renderer.h"

namespace vitrine {

enum class DensifyStrategy { Divide, Classic, None };
struct DensifyConfig {
  DensifyStrategy strategy = DensifyStrategy::Divide;
  int every = 50;                   // steps, rounded up to whole passes through the photos
  double from = 0.05, until = 0.7;  // parts of the run
  double growth = 1.1;              // of the number of surfels in `every` steps (divide)
  double idle_weight = 0.02;        // surfels whose sum of blending weights is below this part of the mean are moved (divide)
  double split_size_rel = 0.01;     // larger surfels are split, smaller ones cloned, scene radii (classic)
};

// Sums of the surfel statistics since the last densification, and what outlives it.
struct SurfelAccumulator {
  std::vector<float> weight, error, screen_gradient;
  std::vector<uint32_t> seen;  // pictures in which the surfel had weight
  uint32_t pictures = 0;       // of all
  std::vector<float> share;    // of the last pictures, about a hundred: those in which it had weight; copies inherit it

  void reset(size_t size);                         // the sums; new surfels share as many pictures as the mean of all
  void keep_only(std::span<const uint32_t> kept);  // ascending; what outlives the sums, which are to be reset
  // How much longer than the others' the steps of a surfel are to be, so that what few photos show is learnt in as many steps
  // as the rest: mean share / own share, in [1, most].
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
  size_t cap = 0;  // most surfels the layer may have
  int times = 1;   // densifications that this one stands for: it grows as much as they all
  double scene_radius = 1;
};
struct DensifyCounts {
  size_t relocated = 0, added = 0, removed = 0;
};

// When a layer is densified.
struct DensifyRhythm {
  uint64_t interval = 1;  // steps
  int times = 1;          // densifications that one stands for
  uint64_t pictures = 0;  // that the sums must be of: a layer that was changed from outside begins anew between two
};
// Every `every` steps, rounded up to whole passes through the photos, so that each has its say about which surfels are idle: one
// that a single photo shows would else be taken away whenever that photo's turn did not come. Where a pass does not fit into the
// `window` (steps from `from` until `until`), every `every` steps all the same: fewer surfels than allowed are worse.
DensifyRhythm densify_rhythm(const DensifyConfig& config, size_t photos, double window);

// By the strategy of `config`. The caller decides when (densify_rhythm, from, until).
DensifyCounts densify(const DensifyConfig& config, const DensifyMoment& moment, DensifyTarget target);

// mu += S xi * sigmoid(100 (0.005 - o)) * strength, with S = s_u^2 r0 r0^T + s_v^2 r1 r1^T: nearly transparent surfels wander.
void add_position_noise(SplatLayer& layer, float strength, uint64_t seed, uint64_t step);

}  // namespace vitrine
