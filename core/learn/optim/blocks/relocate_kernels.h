// Statistics of surfels and relocation (strategy `divide` of densify.h) as kernels for a GPU. Surfels are drawn by integers:
// chances are rounded to parts of 2^31, so that their sums depend on no order.
#pragma once

#include <cmath>

#include "core/foundation/math/rigid.h"
#include "core/learn/optim/blocks/adam_kernels.h"
#include "core/learn/optim/blocks/statistics_kernels.h"
#include "core/render/raster/blocks/radix_sort.h"
#include "core/render/raster/blocks/tree_sum.h"
#include "core/scene/surfels/activation.h"

namespace vitrine::blocks {

// A thread for each surfel: whether it is relocated, and its chance to be divided.
struct ChanceKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const float *opacity, *weight, *error;
  const float *weight_sum, *error_sum;
  float idle_weight;
  uint32_t* dead;
  float* chance;
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= surfels) return;
    const F32 n(static_cast<float>(surfels)), o = sigmoid(F32(opacity[i])), mean_error = F32(*error_sum) / n;
    dead[i] = o <= F32(kDeadOpacity) || F32(weight[i]) < F32(idle_weight) * F32(*weight_sum) / n ? 1 : 0;
    chance[i] = dead[i] != 0 ? 0.f : division_chance(o, F32(error[i]), mean_error).v;
  }
};

// Chances in parts of 2^31 of their sum.
struct ChancePartsKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const float *chance, *sum;
  uint32_t* parts;
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i < surfels) parts[i] = *sum > 0.f ? static_cast<uint32_t>((F32(chance[i]) / F32(*sum) * F32(0x1p31f)).v) : 0;
  }
};

// Slots of the surfels that are relocated, ascending.
struct SlotKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint32_t *dead, *before;  // before: of the dead
  uint32_t* slots;
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i < surfels && dead[i] != 0) slots[before[i]] = i;
  }
};

// A thread for each slot: the surfel that is divided for it.
struct ParentKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint32_t* draws;   // below the sum of the parts
  const uint32_t* before;  // sums of the parts of earlier surfels
  const uint32_t* slots;   // null: first_slot, first_slot + 1, ...
  SortedPairs out;         // parent, slot
  uint32_t surfels, count, first_slot;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t k = at.block * kThreads + at.thread;
    if (k >= count) return;
    uint32_t low = 0, high = surfels;  // the last surfel with before <= draw lies in [low, high)
    while (high - low > 1) {
      const uint32_t middle = low + (high - low) / 2;
      (before[middle] <= draws[k] ? low : high) = middle;
    }
    out.keys[k] = low;
    out.values[k] = slots == nullptr ? first_slot + k : slots[k];
  }
};

// A thread for each parent divides it once for each of its slots, in their order.
struct DivideKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  SortedPairs sorted;  // by parent
  AdamColumns columns;
  uint32_t* steps;
  float* share;
  uint32_t count;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t first = at.block * kThreads + at.thread;
    if (first >= count || (first > 0 && sorted.keys[first - 1] == sorted.keys[first])) return;
    const uint32_t parent = static_cast<uint32_t>(sorted.keys[first]);
    for (uint32_t k = first; k < count && sorted.keys[k] == parent; ++k) {
      divide(parent, sorted.values[k]);
      share[sorted.values[k]] = share[parent];
      forget(sorted.values[k]);
    }
    forget(parent);
  }
  VITRINE_HD float* value(Attribute a, uint32_t i) const {
    const AdamColumn& c = columns.column[static_cast<size_t>(a)];
    return c.x + size_t{c.width} * i;
  }
  VITRINE_HD void divide(uint32_t parent, uint32_t copy) const {
    float* log_scale = value(Attribute::LogScale, parent);
    const uint32_t longer = log_scale[1] > log_scale[0] ? 1 : 0;
    const float* q = value(Attribute::Rotation, parent);
    const Mat3<F32> axes = rotation_matrix(normalized(Quat<F32>{q[0], q[1], q[2], q[3]}));
    const Vec3<F32> axis = longer != 0 ? axes.c1 : axes.c0;
    const F32 offset = F32(kHalfOffset) * exp(F32(log_scale[longer]));
    log_scale[longer] = (F32(log_scale[longer]) + F32(-0.653926467f)).v;           // ln kHalfLong
    log_scale[1 - longer] = (F32(log_scale[1 - longer]) + F32(-0.0512932944f)).v;  // ln kHalfShort
    for (const AdamColumn& c : columns.column)
      for (uint32_t k = 0; k < c.width; ++k) c.x[size_t{c.width} * copy + k] = c.x[size_t{c.width} * parent + k];
    for (size_t k = 0; k < 3; ++k) {
      float &at_parent = value(Attribute::Mean, parent)[k], &at_copy = value(Attribute::Mean, copy)[k];
      const F32 centre(at_parent), shift = offset * axis[k];
      at_parent = (centre - shift).v;
      at_copy = (centre + shift).v;
    }
  }
  VITRINE_HD void forget(uint32_t i) const {
    for (const AdamColumn& c : columns.column)
      for (uint32_t k = 0; k < c.width; ++k) c.m[size_t{c.width} * i + k] = c.v[size_t{c.width} * i + k] = 0.f;
    steps[i] = 0;
  }
};

struct RelocateDesc {
  uint64_t seed, step;
  double idle_weight;  // DensifyConfig
  double growth;       // of the number of surfels in this densification
  uint32_t cap;
};

template <class Executor>
class RelocateBlocks {
 public:
  struct Counts {
    uint32_t relocated, added;
  };
  // As densify() with `divide`, but the statistics stay. The arrays have room for `cap` surfels; the columns stand in the order
  // of Attribute. Waits for the device: two counts decide how many numbers are drawn.
  Counts run(Executor& executor, const RelocateDesc& desc, const AdamColumns& columns, uint32_t* steps,
             const AccumulatorArrays& sums, uint32_t surfels) {
    for (auto* values : {&dead_, &before_dead_, &parts_, &slots_}) values->resize(surfels);
    chance_.resize(surfels);
    const float *weight_sum = tree_sum(executor, weight_sum_, sums.weight, surfels),
                *error_sum = tree_sum(executor, error_sum_, sums.error, surfels);
    const float* opacity = columns.column[static_cast<size_t>(Attribute::Opacity)].x;
    launch(executor, surfels,
           ChanceKernel{opacity, sums.weight, sums.error, weight_sum, error_sum, static_cast<float>(desc.idle_weight),
                        dead_.data(), chance_.data(), surfels});
    const float* chance_sum = tree_sum(executor, chance_sum_, chance_.data(), surfels);
    launch(executor, surfels, ChancePartsKernel{chance_.data(), chance_sum, parts_.data(), surfels});
    const uint32_t all = executor.read(exclusive_scan(executor, scan_, parts_.data(), parts_.data(), surfels));
    const uint32_t dead = executor.read(exclusive_scan(executor, scan_, dead_.data(), before_dead_.data(), surfels));
    if (all == 0) return {0, 0};
    launch(executor, surfels, SlotKernel{dead_.data(), before_dead_.data(), slots_.data(), surfels});
    const double grown = std::min(double{1} * desc.cap, std::ceil(double{1} * surfels * desc.growth));
    const uint32_t added = grown > surfels ? static_cast<uint32_t>(grown) - surfels : 0;
    divide(executor, Rng(desc.seed, mix64(kRelocateStream, desc.step)), all, slots_.data(), surfels, dead, columns, steps,
           sums.share);
    divide(executor, Rng(desc.seed, mix64(kGrowStream, desc.step)), all, nullptr, surfels, added, columns, steps, sums.share);
    return {dead, added};
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;
  template <class Kernel>
  static void launch(Executor& executor, size_t items, const Kernel& kernel) {
    executor.launch(kernel, blocks_for(items, Kernel::kThreads));
  }
  void divide(Executor& executor, Rng draw, uint32_t all, const uint32_t* slots, uint32_t surfels, uint32_t count,
              const AdamColumns& columns, uint32_t* steps, float* share) {
    if (count == 0) return;
    std::vector<uint32_t> draws(count);
    for (uint32_t& d : draws) d = static_cast<uint32_t>(draw.uniform_double() * all);
    draws_.resize(count);
    executor.upload(draws_.data(), draws.data(), count);
    sort_.resize(count);
    launch(executor, count,
           ParentKernel{draws_.data(), parts_.data(), slots, {sort_.keys.data(), sort_.values.data()}, surfels, count, surfels});
    const SortedPairs sorted = radix_sort(executor, sort_, count, 0, 32);
    launch(executor, count, DivideKernel{sorted, columns, steps, share, count});
  }

  TreeSumMemory<Executor> weight_sum_, error_sum_, chance_sum_;
  ScanMemory<Executor> scan_;
  SortMemory<Executor> sort_;
  Array<uint32_t> dead_, before_dead_, parts_, slots_, draws_;
  Array<float> chance_;
};

}  // namespace vitrine::blocks
