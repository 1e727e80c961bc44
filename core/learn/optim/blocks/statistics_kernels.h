// Statistics of surfels as kernels for a GPU, a thread for each surfel, and what steps depend on them: which surfels take part,
// by how much their steps are longer, and the least colour (LayerTraining::descend, SurfelAccumulator).
#pragma once

#include "core/foundation/math/spherical_harmonics.h"
#include "core/learn/optim/densify_rules.h"
#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/raster/blocks/f32.h"

namespace vitrine::blocks {

// SurfelAccumulator of the device, [n].
struct AccumulatorArrays {
  float *weight, *error, *screen_gradient, *share;
  uint32_t* seen;
};

// SurfelAccumulator::add, a thread for each surfel.
struct StatisticsKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const float *weight, *error, *screen_gradient;  // of the picture
  AccumulatorArrays sums;
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= surfels) return;
    const bool takes_part = weight[i] > 0.f;
    const F32 share(sums.share[i]);
    sums.share[i] = (share + F32(kShareDecay) * (F32(takes_part ? 1.f : 0.f) - share)).v;
    if (!takes_part) return;
    sums.weight[i] = (F32(sums.weight[i]) + F32(weight[i])).v;
    sums.error[i] = (F32(sums.error[i]) + F32(error[i])).v;
    sums.screen_gradient[i] = (F32(sums.screen_gradient[i]) + F32(screen_gradient[i])).v;
    ++sums.seen[i];
  }
};

// Surfels with weight in the picture take a step, but for those behind the first `trained`. Its factors: all, by how seldom
// photos show the surfel (SurfelAccumulator::rarity); place, by its distance (far_factor).
struct FactorKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const float *weight, *share, *share_sum, *mean;  // mean: positions [n,3]
  float rarest;                                    // largest factor
  uint8_t* active;
  float *all, *place;
  uint32_t surfels, trained;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= surfels) return;
    active[i] = i < trained && weight[i] > 0.f ? 1 : 0;
    const F32 mean_share = F32(*share_sum) / F32(static_cast<float>(surfels));
    all[i] = rarity_factor(mean_share, F32(share[i]), F32(rarest)).v;
    const float* m = mean + size_t{3} * i;
    place[i] = far_factor(Vec3<F32>{F32(m[0]), F32(m[1]), F32(m[2])}).v;
  }
};

// After a step: colours stay above zero, where they have a gradient.
struct LeastColourKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint8_t* active;
  float* sh_dc;  // [n,3]
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= surfels || active[i] == 0) return;
    constexpr float kLeast = (kLeastColour - 0.5f) / kShDc;
    for (size_t c = 0; c < 3; ++c) sh_dc[size_t{3} * i + c] = max(F32(sh_dc[size_t{3} * i + c]), F32(kLeast)).v;
  }
};

}  // namespace vitrine::blocks
