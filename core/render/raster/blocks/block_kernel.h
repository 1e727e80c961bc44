// Kernels as lists of phases between barriers, and their execution on the CPU. A kernel is a struct with
//
//   static constexpr uint32_t kThreads;   threads of a block
//   struct Shared, struct Thread;         memory of a block; values that a thread keeps from phase to phase
//   bool has_phase(uint32_t phase, const Shared&) const;              the same for all threads of a block
//   void run(uint32_t phase, Place, Thread&, Shared&) const;          one phase of one thread
//
// Its members point to arrays. Within a phase no thread may read what another thread of the launch writes: then the result
// depends on no order, and loops on the CPU (BlockLoops) and threads of a GPU (CUDA: blocks/cuda_launch.cuh) give the same bytes.
// What has_phase(phase) reads must not be written in that phase.
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/vec.h"

namespace vitrine::blocks {

struct Place {
  uint32_t block, thread;
};

// Any number of threads may set bits of a word in one phase.
VITRINE_HD inline void set_bits(uint32_t& word, uint32_t bits) {
#ifdef __CUDA_ARCH__
  atomicOr(&word, bits);
#else
  std::atomic_ref(word).fetch_or(bits, std::memory_order_relaxed);
#endif
}
VITRINE_HD inline void set_flag(uint32_t& flag) { set_bits(flag, 1); }
VITRINE_HD inline uint32_t bit_count(uint32_t word) {
#ifdef __CUDA_ARCH__
  return static_cast<uint32_t>(__popc(word));
#else
  return static_cast<uint32_t>(__builtin_popcount(word));
#endif
}

// The device failed or is missing; the text names what and why.
struct ExecutorFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};
// It gave no more memory, in bytes.
struct ExecutorMemory : ExecutorFailure {
  ExecutorMemory(size_t needed_now, size_t held_already, size_t left)
      : ExecutorFailure("too little memory"), needed(needed_now), held(held_already), free(left) {}
  size_t needed, held, free;
};
// More items than 32 bits count. `what`: of which kind.
struct ExecutorOverflow : ExecutorFailure {
  using ExecutorFailure::ExecutorFailure;
};

// Sum that stays at the largest number instead of starting again at 0: like the plain sum it depends on no order.
VITRINE_HD inline uint32_t bounded_sum(uint32_t a, uint32_t b) { return a + b < a ? ~0u : a + b; }
// The threads of a last block that is not full have numbers, too.
inline constexpr uint32_t kMostItems = ~0u - 4096;
// A sum of bounded_sum that indices can have.
inline uint32_t checked_count(uint32_t count, const char* what) {
  if (count > kMostItems) throw ExecutorOverflow(what);
  return count;
}

struct NoShared {};
struct NoThread {};

// Blocks needed for one thread per item.
constexpr uint32_t blocks_for(size_t items, uint32_t items_of_block) {
  return static_cast<uint32_t>((items + items_of_block - 1) / items_of_block);
}

// Runs kernels on the CPU.
class BlockLoops {
 public:
  // seed 0: blocks in parallel, threads in order. Otherwise one block after another, in an order that the seed shuffles, as it
  // shuffles the threads of each phase; memory of a block then begins with values that the seed chooses.
  explicit BlockLoops(uint64_t shuffle_seed = 0) : seed_(shuffle_seed) {}

  template <class T>
  using Array = std::vector<T>;

  template <class Kernel>
  void launch(const Kernel& kernel, uint32_t blocks) {
    ++launches_;
    if (seed_ == 0) {
      parallel_for(blocks, 1, [&](size_t block) { run_block(kernel, static_cast<uint32_t>(block)); });
      return;
    }
    for (const uint32_t block : shuffled(blocks, 0)) run_block(kernel, block);
  }

  // Bytes that arrays can still take.
  size_t free_memory() const { return ~size_t{0}; }
  // One value that a kernel wrote.
  template <class T>
  T read(const T* value) const {
    return *value;
  }
  template <class T>
  void upload(T* to, const T* from, size_t size) const {
    std::copy(from, from + size, to);
  }
  template <class T>
  void download(T* to, const T* from, size_t size) const {
    std::copy(from, from + size, to);
  }

 private:
  template <class Kernel>
  void run_block(const Kernel& kernel, uint32_t block) const {
    const auto shared = std::make_unique<typename Kernel::Shared>();
    const auto threads = std::make_unique<std::array<typename Kernel::Thread, Kernel::kThreads>>();
    if (seed_ != 0) {
      std::memset(static_cast<void*>(shared.get()), static_cast<int>(mix64(seed_, block) & 0xff),
                  sizeof(typename Kernel::Shared));
      std::memset(static_cast<void*>(threads.get()), static_cast<int>(mix64(seed_, block + 1) & 0xff), sizeof(*threads));
    }
    std::vector<uint32_t> order(Kernel::kThreads);
    std::iota(order.begin(), order.end(), 0u);
    for (uint32_t phase = 0; kernel.has_phase(phase, *shared); ++phase) {
      if (seed_ != 0) order = shuffled(Kernel::kThreads, mix64(block, phase + 1));
      for (const uint32_t thread : order) kernel.run(phase, {block, thread}, (*threads)[thread], *shared);
    }
  }

  std::vector<uint32_t> shuffled(uint32_t count, uint64_t stream) const {
    std::vector<uint32_t> order(count);
    std::iota(order.begin(), order.end(), 0u);
    Rng rng(mix64(seed_, launches_), stream);
    for (uint32_t i = count; i > 1; --i) std::swap(order[i - 1], order[rng.below(i)]);
    return order;
  }

  uint64_t seed_, launches_ = 0;
};

}  // namespace vitrine::blocks
