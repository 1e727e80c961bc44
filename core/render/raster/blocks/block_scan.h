// Sums of all earlier entries of an array of integers (exclusive scan), in three kernels: sums of blocks, sums of those, and
// their addition. Integers only: the order in which they are added changes nothing. Sums that 32 bits cannot hold are ~0u.
#pragma once

#include "core/render/raster/blocks/block_kernel.h"

namespace vitrine::blocks {

// Inclusive scan of one number a thread over a block of 256 threads, in kSteps phases (Hillis and Steele 1986). Phase `step` of
// each thread calls step(); before the first, sums[0][thread] is set, after the last it has the result.
struct BlockSums {
  static constexpr uint32_t kThreads = 256, kSteps = 8;
  uint32_t sums[2][kThreads];

  VITRINE_HD void step(uint32_t step, uint32_t thread) {
    const uint32_t(&from)[kThreads] = sums[step & 1];
    const uint32_t reach = 1u << step;
    sums[(step + 1) & 1][thread] = bounded_sum(from[thread], thread >= reach ? from[thread - reach] : 0);
  }
  VITRINE_HD uint32_t before(uint32_t thread) const { return thread == 0 ? 0 : sums[0][thread - 1]; }
  VITRINE_HD uint32_t total() const { return sums[0][kThreads - 1]; }
};
static_assert(1u << BlockSums::kSteps == BlockSums::kThreads && BlockSums::kSteps % 2 == 0);

// out[i] = sum of in[j], j < i, within runs of `run` entries, one run a block; totals[block] = sum of the run. `in` may be `out`.
struct ScanKernel {
  static constexpr uint32_t kThreads = BlockSums::kThreads;
  using Shared = BlockSums;
  struct Thread {
    uint32_t sum;
  };
  const uint32_t* in;
  uint32_t* out;
  uint32_t* totals;
  uint32_t size, run_length;  // run_length: a multiple of kThreads

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < BlockSums::kSteps + 2; }
  VITRINE_HD void run(uint32_t phase, Place at, Thread& t, Shared& shared) const {
    const uint32_t own = run_length / kThreads, begin = at.block * run_length + at.thread * own;
    if (phase == 0) {
      t.sum = 0;
      for (uint32_t i = begin; i < begin + own && i < size; ++i) t.sum = bounded_sum(t.sum, in[i]);
      shared.sums[0][at.thread] = t.sum;
    } else if (phase <= BlockSums::kSteps) {
      shared.step(phase - 1, at.thread);
    } else {
      uint32_t sum = shared.before(at.thread);
      for (uint32_t i = begin; i < begin + own && i < size; ++i) {
        const uint32_t value = in[i];
        out[i] = sum;
        sum = bounded_sum(sum, value);
      }
      if (at.thread == 0) totals[at.block] = shared.total();
    }
  }
};

// Adds to each entry of a run the sum of the runs before it.
struct AddTotalsKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  uint32_t* out;
  const uint32_t* totals;
  uint32_t size, run_length;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i < size) out[i] = bounded_sum(out[i], totals[i / run_length]);
  }
};

template <class Executor>
struct ScanMemory {
  static constexpr uint32_t kRun = 8 * BlockSums::kThreads;
  typename Executor::template Array<uint32_t> totals;  // of the runs, and of everything at the end
};

// out[i] = sum of in[j], j < i < size. Returns a pointer to the sum of all, in the executor's memory. `in` may be `out`.
template <class Executor>
const uint32_t* exclusive_scan(Executor& executor, ScanMemory<Executor>& memory, const uint32_t* in, uint32_t* out,
                               uint32_t size) {
  constexpr uint32_t kRun = ScanMemory<Executor>::kRun;
  const uint32_t runs = blocks_for(size, kRun);
  memory.totals.resize(runs + 1);
  uint32_t* const totals = memory.totals.data();
  if (runs > 0) executor.launch(ScanKernel{in, out, totals, size, kRun}, runs);
  // All runs in one block, as many entries a thread as it takes.
  executor.launch(
      ScanKernel{totals, totals, totals + runs, runs, blocks_for(runs + 1, BlockSums::kThreads) * BlockSums::kThreads}, 1);
  if (runs > 1) executor.launch(AddTotalsKernel{out, totals, size, kRun}, blocks_for(size, AddTotalsKernel::kThreads));
  return totals + runs;
}

}  // namespace vitrine::blocks
