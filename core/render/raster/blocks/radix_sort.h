// Stable radix sort of 64-bit keys with 32-bit values: four bits a pass, counted by thread, so that no atomics are needed and
// equal keys stay in order. A thread has kOwn consecutive entries; a block counts its entries by digit, a scan over digits and
// blocks gives each (digit, block) its place, and the block counts again and moves its entries.
#pragma once

#include "core/render/raster/blocks/block_scan.h"

namespace vitrine::blocks {

struct SortedPairs {
  uint64_t* keys;
  uint32_t* values;
};

struct RadixDigits {
  static constexpr uint32_t kBits = 4, kCount = 1u << kBits, kThreads = BlockSums::kThreads, kOwn = 8, kOfBlock = kThreads * kOwn;
  static_assert(kCount <= kThreads);
  uint32_t counts[kCount][kThreads];  // entries of each thread by digit; rows one after another are the sorted order
  BlockSums sums;

  VITRINE_HD void count(const uint64_t* keys, uint32_t size, uint32_t shift, Place at) {
    for (uint32_t d = 0; d < kCount; ++d) counts[d][at.thread] = 0;
    const uint32_t begin = at.block * kOfBlock + at.thread * kOwn;
    for (uint32_t i = begin; i < begin + kOwn && i < size; ++i) ++counts[digit(keys[i], shift)][at.thread];
  }
  VITRINE_HD static uint32_t digit(uint64_t key, uint32_t shift) { return static_cast<uint32_t>(key >> shift) & (kCount - 1); }
};

// counts[digit * blocks + block]: entries of the block with this digit.
struct RadixCountKernel {
  static constexpr uint32_t kThreads = RadixDigits::kThreads;
  using Shared = RadixDigits;
  using Thread = NoThread;
  const uint64_t* keys;
  uint32_t* counts;
  uint32_t size, shift, blocks;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 2; }
  VITRINE_HD void run(uint32_t phase, Place at, Thread&, Shared& shared) const {
    if (phase == 0) {
      shared.count(keys, size, shift, at);
    } else if (at.thread < RadixDigits::kCount) {
      uint32_t sum = 0;
      for (uint32_t t = 0; t < kThreads; ++t) sum += shared.counts[at.thread][t];
      counts[at.thread * blocks + at.block] = sum;
    }
  }
};

// `places`: the scan of RadixCountKernel::counts.
struct RadixMoveKernel {
  static constexpr uint32_t kThreads = RadixDigits::kThreads;
  using Shared = RadixDigits;
  struct Thread {
    uint32_t sum;
  };
  const uint64_t* keys;
  const uint32_t* values;
  SortedPairs out;
  const uint32_t* places;
  uint32_t size, shift, blocks;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < BlockSums::kSteps + 4; }
  VITRINE_HD void run(uint32_t phase, Place at, Thread& t, Shared& shared) const {
    // The table as one row: a thread sums kCount consecutive entries of it.
    constexpr uint32_t kOwn = RadixDigits::kCount;
    uint32_t* const row = shared.counts[0] + at.thread * kOwn;
    if (phase == 0) {
      shared.count(keys, size, shift, at);
    } else if (phase == 1) {
      t.sum = 0;
      for (uint32_t i = 0; i < kOwn; ++i) t.sum += row[i];
      shared.sums.sums[0][at.thread] = t.sum;
    } else if (phase < BlockSums::kSteps + 2) {
      shared.sums.step(phase - 2, at.thread);
    } else if (phase == BlockSums::kSteps + 2) {
      uint32_t sum = shared.sums.before(at.thread);
      for (uint32_t i = 0; i < kOwn; ++i) {
        const uint32_t count = row[i];
        row[i] = sum;
        sum += count;
      }
    } else {
      move(at, shared);
    }
  }
  VITRINE_HD void move(Place at, const Shared& shared) const {
    const uint32_t begin = at.block * RadixDigits::kOfBlock + at.thread * RadixDigits::kOwn;
    for (uint32_t i = begin; i < begin + RadixDigits::kOwn && i < size; ++i) {
      const uint32_t d = RadixDigits::digit(keys[i], shift);
      uint32_t earlier = 0;  // of the thread's own with this digit
      for (uint32_t j = begin; j < i; ++j) earlier += RadixDigits::digit(keys[j], shift) == d;
      const uint32_t rank =
          shared.counts[d][at.thread] - shared.counts[d][0] + earlier;  // among those of the block with this digit
      const uint32_t to = places[d * blocks + at.block] + rank;
      out.keys[to] = keys[i];
      out.values[to] = values[i];
    }
  }
};

template <class Executor>
struct SortMemory {
  typename Executor::template Array<uint64_t> keys, other_keys;
  typename Executor::template Array<uint32_t> values, other_values, counts;
  ScanMemory<Executor> scan;
  void resize(uint32_t size) {
    keys.resize(size);
    other_keys.resize(size);
    values.resize(size);
    other_values.resize(size);
  }
};

// Sorts the first `size` pairs of memory.keys and memory.values by bits [first_bit, last_bit) of the key. Returns where they are.
template <class Executor>
SortedPairs radix_sort(Executor& executor, SortMemory<Executor>& memory, uint32_t size, uint32_t first_bit, uint32_t last_bit) {
  SortedPairs from{memory.keys.data(), memory.values.data()}, to{memory.other_keys.data(), memory.other_values.data()};
  const uint32_t blocks = blocks_for(size, RadixDigits::kOfBlock);
  if (blocks == 0) return from;
  memory.counts.resize(RadixDigits::kCount * blocks);
  uint32_t* const counts = memory.counts.data();
  for (uint32_t shift = first_bit; shift < last_bit; shift += RadixDigits::kBits) {
    executor.launch(RadixCountKernel{from.keys, counts, size, shift, blocks}, blocks);
    exclusive_scan(executor, memory.scan, counts, counts, RadixDigits::kCount * blocks);
    executor.launch(RadixMoveKernel{from.keys, from.values, to, counts, size, shift, blocks}, blocks);
    const SortedPairs done = to;
    to = from;
    from = done;
  }
  return from;
}

}  // namespace vitrine::blocks
