// The random walk of nearly transparent surfels (add_position_noise) as a kernel for a GPU, from the random numbers of the CPU.
#pragma once

#include "core/foundation/math/rigid.h"
#include "core/learn/optim/densify_rules.h"
#include "core/render/raster/blocks/project_kernel.h"

namespace vitrine::blocks {

// Rng::normal() from the two 64-bit numbers that it consumes; absolute error 2e-6. Their upper 53 bits are fractions of 2^53.
VITRINE_HD inline F32 normal_deviate(uint64_t first, uint64_t second) {
  constexpr uint64_t kOne = uint64_t{1} << 53;
  const uint64_t below_one = first >> 11;  // the logarithm is that of 1 less this
  F32 logarithm;
  if (below_one < kOne / 4) {
    const F32 e = F32(static_cast<float>(below_one)) * F32(0x1p-53f);
    logarithm = log_of_ratio(-e / (F32(2.f) - e));
  } else {
    logarithm = log(F32(static_cast<float>(kOne - below_one)) * F32(0x1p-53f));
  }
  // The angle is a number of quarter turns, and a rest of at most half a quarter.
  const uint64_t turn = second >> 11, quarters = (turn + kOne / 8) / (kOne / 4);
  const int64_t rest = static_cast<int64_t>(turn) - static_cast<int64_t>(quarters * (kOne / 4));
  const F32 x = F32(static_cast<float>(rest)) * F32(0x1p-51f) * F32(1.57079633f), xx = x * x;
  F32 wave;
  if (quarters % 2 == 0) {
    wave = fma(F32(1.f / 40320), xx, F32(-1.f / 720));
    wave = fma(wave, xx, F32(1.f / 24));
    wave = fma(wave, xx, F32(-0.5f));
    wave = fma(wave, xx, F32(1.f));
  } else {
    wave = fma(F32(-1.f / 5040), xx, F32(1.f / 120));
    wave = fma(wave, xx, F32(-1.f / 6));
    wave = fma(wave * xx, x, x);
  }
  const F32 radius = sqrt(F32(-2.f) * logarithm);
  return quarters % 4 == 1 || quarters % 4 == 2 ? -(radius * wave) : radius * wave;
}

// A thread for each surfel.
struct NoiseKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  SurfelArrays from;
  float* mean;  // of the same surfels
  float strength;
  uint64_t seed, step;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= from.count) return;
    const F32 gate = noise_gate(sigmoid(F32(from.opacity[i])));
    if (gate < F32(NoiseRule::kLeastGate)) return;
    const uint64_t key = mix64(seed, mix64(kNoiseStream, mix64(step, i)));  // Rng(seed, ...)
    Vec3<F32> xi;
    for (size_t c = 0; c < 3; ++c) xi[c] = normal_deviate(mix64(key, 2 * c), mix64(key, 2 * c + 1));
    const SurfelGeometry<F32> s = geometry_of(from, i);
    const Mat3<F32> axes = rotation_matrix(normalized(s.rotation));
    const F32 u = exp(s.log_su + s.log_su) * dot(axes.c0, xi), v = exp(s.log_sv + s.log_sv) * dot(axes.c1, xi);
    const F32 walk = gate * F32(strength) / far_factor(s.mean);
    for (size_t c = 0; c < 3; ++c) mean[size_t{3} * i + c] = (s.mean[c] + walk * (u * axes.c0[c] + v * axes.c1[c])).v;
  }
};

// As add_position_noise(). `mean`: positions of the surfels, which may be those that they point to.
template <class Executor>
void add_position_noise(Executor& executor, const SurfelArrays& surfels, float* mean, float strength, uint64_t seed,
                        uint64_t step) {
  if (strength > 0)
    executor.launch(NoiseKernel{surfels, mean, strength, seed, step}, blocks_for(surfels.count, NoiseKernel::kThreads));
}

}  // namespace vitrine::blocks
