// Photos and masks as they are kept, in 16 and 8 bits, to what the losses compare, as kernels for a GPU: the formulas of
// Training::look().
#pragma once

#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/raster/blocks/f32.h"

namespace vitrine::blocks {

// A thread for each value of a photo: where it is clipped, a brighter prediction agrees with it and becomes the target.
struct TargetKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint16_t* photo;
  const float* prediction;
  float* target;
  float clipped;
  size_t size;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const size_t i = size_t{at.block} * kThreads + at.thread;
    if (i >= size) return;
    const F32 value = F32(static_cast<float>(photo[i])) * F32(1.f / 65535.f);
    target[i] = (value >= F32(clipped) ? max(F32(prediction[i]), value) : value).v;
  }
};

// A thread for each value.
template <class T>
struct ScaleKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  const T* in;
  float* out;
  float factor;
  size_t size;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const size_t i = size_t{at.block} * kThreads + at.thread;
    if (i < size) out[i] = (F32(static_cast<float>(in[i])) * F32(factor)).v;
  }
};

// A thread for each pixel: weight of the picture losses (Training::weigh_pixels). Masks are null where there are none.
struct PixelWeightKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  const uint8_t *ignore, *object, *specular, *transparent, *coat;
  float specular_weight;  // on mirrors
  bool withheld;
  float* weight;
  uint32_t pixels;

  // Whether a weight is not one.
  bool needed() const {
    const bool interfaces = specular != nullptr || (withheld && (transparent != nullptr || coat != nullptr));
    return ignore != nullptr || object != nullptr || (interfaces && (withheld || specular_weight != 1));
  }
  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= pixels) return;
    F32 w(1.f);
    if (ignore != nullptr) w *= F32(1.f) - mask(ignore, i);
    if (object != nullptr) w *= mask(object, i);
    const uint8_t* const interfaces[] = {specular, transparent, coat};
    for (const uint8_t* m : interfaces)
      if (withheld && m != nullptr) w *= F32(1.f) - mask(m, i);
    if (specular_weight != 1 && specular != nullptr) {
      const F32 open = transparent == nullptr ? F32(1.f) : F32(1.f) - mask(transparent, i);
      w *= F32(1.f) + (F32(specular_weight) - F32(1.f)) * (mask(specular, i) * open);
    }
    weight[i] = w.v;
  }
  VITRINE_HD static F32 mask(const uint8_t* m, uint32_t i) { return F32(static_cast<float>(m[i])) * F32(1.f / 255.f); }
};

// to[i] = from[i], a thread for each value.
template <class From, class To = From>
struct CopyKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  const From* from;
  To* to;
  size_t size;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const size_t i = size_t{at.block} * kThreads + at.thread;
    if (i < size) to[i] = static_cast<To>(from[i]);
  }
};

}  // namespace vitrine::blocks
