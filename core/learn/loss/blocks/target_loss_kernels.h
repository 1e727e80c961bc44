// The losses with targets (specular_mask.cpp, mask_cross_entropy.cpp, monocular_normal.cpp) as kernels for a GPU, a thread for
// each pixel. All add to gradients of their pixel, and write v times the term to `value`, v = 1 - ignore.
#pragma once

#include "core/learn/loss/blocks/plane_loss_kernels.h"
#include "core/learn/loss/target_kernel.h"

namespace vitrine::blocks {

// A mask [h,w] with the pixels that count, and the factor of the gradients.
struct MaskedPixels {
  const float *mask, *ignore, *ignored;  // ignored: sum of `ignore`; both null: all count
  float factor;
  uint32_t count;
  VITRINE_HD F32 valid(uint32_t i) const { return ignore == nullptr ? F32(1.f) : F32(1.f) - F32(ignore[i]); }
  // factor / sum of v; 0 if no pixel counts.
  VITRINE_HD F32 step() const {
    const F32 sum = F32(static_cast<float>(count)) - (ignored == nullptr ? F32(0.f) : F32(*ignored));
    return sum > F32(0.f) ? F32(factor) / sum : F32(0.f);
  }
};

// `transparent`, `coat`: masks of pixels that do not count, or null.
struct SpecularMaskKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  MaskedPixels pixels;
  const float *channel, *transparent, *coat;
  float *gradient, *value;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= pixels.count) return;
    F32 v = pixels.valid(i);
    if (transparent != nullptr) v *= F32(1.f) - F32(transparent[i]);
    if (coat != nullptr) v *= F32(1.f) - F32(coat[i]);
    const ChannelTerm<F32> term = specular_mask_term(F32(channel[i]), F32(pixels.mask[i]));
    gradient[i] = (F32(gradient[i]) + pixels.step() * v * term.slope).v;
    value[i] = (v * term.value).v;
  }
};

struct CrossEntropyKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  MaskedPixels pixels;
  const float* channel;
  float *gradient, *value;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= pixels.count) return;
    const F32 v = pixels.valid(i);
    const ChannelTerm<F32> term = cross_entropy_term(F32(channel[i]), F32(pixels.mask[i]));
    gradient[i] = (F32(gradient[i]) + pixels.step() * v * term.slope).v;
    value[i] = (v * term.value).v;
  }
};

// Normals of the camera frame [3,h,w] as targets; a factor for each pixel.
struct TargetNormalKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  Planes3<const float> normal;
  Mat3<F32> cam_from_world;
  const float *alpha, *target, *confidence, *ignore;  // the last two, or null: 1 and 0
  float factor;
  uint32_t pixels;
  Planes3<float> gradient;
  float* value;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= pixels) return;
    value[i] = 0.f;
    const Vec3<F32> t{F32(target[i]), F32(target[size_t{pixels} + i]), F32(target[size_t{2} * pixels + i])};
    const Vec3<F32> blended = normal.at(i);
    const F32 length = sqrt(dot(blended, blended));
    using Usable = UsableNormal;
    if (dot(t, t) < F32(Usable::kShortestTarget) || alpha[i] < Usable::kLeastAlpha || length < F32(Usable::kShortest)) return;
    F32 weight = confidence == nullptr ? F32(1.f) : F32(confidence[i]);
    if (ignore != nullptr) weight *= F32(1.f) - F32(ignore[i]);
    if (weight <= F32(0.f)) return;
    const TargetNormalTerm<F32> term = target_normal_term((F32(1.f) / length) * (cam_from_world * blended), t);
    value[i] = (weight * term.value).v;
    gradient.add(i, (F32(factor) * weight / length) * transposed_times(cam_from_world, term.tangent));
  }
};

}  // namespace vitrine::blocks
