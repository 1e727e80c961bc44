// Sums of floats by a tree whose shape depends on their number alone: each block adds 2048 of them, until one is left.
#pragma once

#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/raster/blocks/f32.h"

namespace vitrine::blocks {

// out[block] = sum of the block's run of `in`.
struct TreeSumKernel {
  static constexpr uint32_t kThreads = 256, kSteps = 8, kOwn = 8, kRun = kThreads * kOwn;
  static_assert(1u << kSteps == kThreads);
  struct Shared {
    float sums[kThreads];
  };
  using Thread = NoThread;
  const float* in;
  float* out;
  uint32_t size;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase <= kSteps; }
  VITRINE_HD void run(uint32_t phase, Place at, Thread&, Shared& shared) const {
    if (phase == 0) {
      F32 sum = 0.f;
      for (uint32_t k = 0; k < kOwn; ++k) {
        const uint32_t i = at.block * kRun + k * kThreads + at.thread;
        if (i < size) sum += F32(in[i]);
      }
      shared.sums[at.thread] = sum.v;
      return;
    }
    const uint32_t half = kThreads >> phase;
    if (at.thread >= half) return;
    const F32 sum = F32(shared.sums[at.thread]) + F32(shared.sums[at.thread + half]);
    shared.sums[at.thread] = sum.v;
    if (half == 1) out[at.block] = sum.v;
  }
};

template <class Executor>
struct TreeSumMemory {
  typename Executor::template Array<float> sums[2];
};

// A pointer to the sum of in[0 ... size), in the executor's memory; it holds until the memory is used again.
template <class Executor>
const float* tree_sum(Executor& executor, TreeSumMemory<Executor>& memory, const float* in, uint32_t size) {
  for (uint32_t level = 0;; ++level) {
    const uint32_t blocks = size == 0 ? 1 : blocks_for(size, TreeSumKernel::kRun);
    auto& out = memory.sums[level % 2];
    out.resize(blocks);
    executor.launch(TreeSumKernel{in, out.data(), size}, blocks);
    if (blocks == 1) return out.data();
    in = out.data();
    size = blocks;
  }
}

}  // namespace vitrine::blocks
