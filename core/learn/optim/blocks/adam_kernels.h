// Adam as kernels for a GPU (core/render/raster/blocks/block_kernel.h): a thread for each surfel counts its step and finds
// gradients that are no numbers, then a thread for each float of an attribute updates it.
#pragma once

#include "core/learn/optim/adam_update.h"
#include "core/render/raster/blocks/block_scan.h"
#include "core/render/raster/blocks/f32.h"
#include "core/scene/surfels/attributes.h"

namespace vitrine::blocks {

// An attribute of all surfels, [n, width].
struct AdamColumn {
  const float* gradient;  // null: zeros
  float *m, *v, *x;
  uint32_t width;      // 0: the layer lacks it
  float rate;          // 0: it is not trained
  bool shape, places;  // StepFactors of adam.h that apply to it
};
struct AdamColumns {
  AdamColumn column[kAttributeCount];
};
// [n] or null.
struct AdamFactors {
  const float *all, *shape, *place;
};

struct AdamSurfelKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  AdamColumns columns;
  const uint8_t* active;
  const float *correction1, *correction2;  // AdamCorrections
  uint32_t last_correction;
  uint32_t* steps;     // of each surfel
  float *step, *root;  // of each surfel: its correction; 0: it stays as it is
  uint32_t* skipped;   // 1: a gradient of an active surfel is no number
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= surfels) return;
    step[i] = root[i] = 0.f;
    skipped[i] = active[i] != 0 && !finite(i) ? 1 : 0;
    if (active[i] == 0 || skipped[i] != 0) return;
    const uint32_t taken = ++steps[i], t = taken < last_correction ? taken : last_correction;
    step[i] = correction1[t];
    root[i] = correction2[t];
  }
  VITRINE_HD bool finite(uint32_t i) const {
    constexpr uint32_t kExponent = 0x7f800000u;
    for (const AdamColumn& c : columns.column)
      for (uint32_t k = 0; c.gradient != nullptr && k < c.width; ++k)
        if ((float_bits(c.gradient[size_t{c.width} * i + k]) & kExponent) == kExponent) return false;
    return true;
  }
};

struct AdamUpdateKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  AdamColumn column;
  AdamFactors factors;
  const float *step, *root;  // of AdamSurfelKernel
  float beta1, beta2, epsilon;
  uint32_t surfels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const size_t j = size_t{at.block} * kThreads + at.thread, i = j / column.width;
    if (i >= surfels || step[i] == 0.f) return;
    F32 rate(column.rate);
    if (factors.all != nullptr) rate *= F32(factors.all[i]);
    if (factors.shape != nullptr && column.shape) rate *= F32(factors.shape[i]);
    if (factors.place != nullptr && column.places) rate *= F32(factors.place[i]);
    F32 m(column.m[j]), v(column.v[j]), x(column.x[j]);
    const F32 gradient(column.gradient == nullptr ? 0.f : column.gradient[j]);
    adam_update<F32>(gradient, {rate * F32(step[i]), F32(root[i]), F32(1.f)}, beta1, beta2, epsilon, m, v, x);
    column.m[j] = m.v;
    column.v[j] = v.v;
    column.x[j] = x.v;
  }
};

template <class Executor>
class AdamBlocks {
 public:
  AdamBlocks(Executor& executor, const AdamDesc& desc) : desc_(desc) {
    const AdamCorrections c = adam_corrections(desc);
    corrections_ = static_cast<uint32_t>(c.first.size());
    for (const auto& [there, here] : {std::pair{&correction1_, &c.first}, std::pair{&correction2_, &c.second}}) {
      there->resize(corrections_);
      executor.upload(there->data(), here->data(), corrections_);
    }
  }

  // As Adam::step(). `steps`: of each surfel, counted here. Returns the number of skipped surfels, in the executor's memory.
  const uint32_t* step(Executor& executor, const AdamColumns& columns, const uint8_t* active, const AdamFactors& factors,
                       uint32_t* steps, uint32_t surfels) {
    step_.resize(surfels);
    root_.resize(surfels);
    skipped_.resize(surfels);
    const AdamSurfelKernel surfel{columns, active,       correction1_.data(), correction2_.data(), corrections_ - 1,
                                  steps,   step_.data(), root_.data(),        skipped_.data(),     surfels};
    executor.launch(surfel, blocks_for(surfels, AdamSurfelKernel::kThreads));
    for (const AdamColumn& c : columns.column)
      if (c.width != 0 && c.rate != 0.f)
        executor.launch(AdamUpdateKernel{c, factors, step_.data(), root_.data(), static_cast<float>(desc_.beta1),
                                         static_cast<float>(desc_.beta2), desc_.epsilon, surfels},
                        blocks_for(size_t{surfels} * c.width, AdamUpdateKernel::kThreads));
    return exclusive_scan(executor, scan_, skipped_.data(), skipped_.data(), surfels);
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;
  AdamDesc desc_;
  uint32_t corrections_;
  Array<float> correction1_, correction2_, step_, root_;
  Array<uint32_t> skipped_;
  ScanMemory<Executor> scan_;
};

}  // namespace vitrine::blocks
