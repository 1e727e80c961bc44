// The picture as a photo shows it (composite_pass.h), and the reverse, as kernels for a GPU: c = srgb(clamp(gain l, 0, 1)).
#pragma once

#include "core/foundation/math/color.h"
#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/raster/blocks/f32.h"

namespace vitrine::blocks {

// x^(5/12), the power of sRGB, of normal numbers in (0, 1]: the cube root by Newton's method, which needs sums, products and
// divisions alone, to the power 5/4. Relative error 2e-7.
VITRINE_HD inline F32 five_twelfths(F32 x) {
  F32 root = float_from_bits(float_bits(x.v) / 3 + 0x2a5137a0u);  // within 4 %
  for (int i = 0; i < 3; ++i) root -= (root * root * root - x) / (F32(3.f) * root * root);
  return root * sqrt(sqrt(root));
}

// Clamped to [0, 1]; what is no number stays so, and the loss shows it.
VITRINE_HD inline F32 displayed(F32 linear) { return min(F32(1.f), max(F32(0.f), linear)); }

// Planes are [3,h,w].
struct DisplayKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const float* linear;
  float* srgb;
  float gain[3];
  uint32_t pixels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t pixel = at.block * kThreads + at.thread;
    if (pixel >= pixels) return;
    for (uint32_t c = 0; c < 3; ++c) {
      const size_t i = size_t{c} * pixels + pixel;
      const F32 l = displayed(F32(gain[c]) * F32(linear[i]));
      srgb[i] = (l > F32(kSrgbKnee) ? F32(1.055f) * five_twelfths(l) - F32(0.055f) : F32(12.92f) * l).v;
    }
  }
};

// gradient: of the displayed picture, then of `linear`. That of a clipped value only moves it back into range (DisplayPass).
struct DisplayReverseKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const float* linear;
  float* gradient;
  float gain[3];
  uint32_t pixels;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t pixel = at.block * kThreads + at.thread;
    if (pixel >= pixels) return;
    for (uint32_t c = 0; c < 3; ++c) {
      const size_t i = size_t{c} * pixels + pixel;
      const F32 whole = F32(gain[c]) * F32(linear[i]), l = displayed(whole), g(gradient[i]);
      const F32 seen = whole > F32(1.f) ? max(g, F32(0.f)) : whole < F32(0.f) ? min(g, F32(0.f)) : g;
      const F32 slope = l > F32(kSrgbKnee) ? F32(1.055f / 2.4f) * five_twelfths(l) / l : F32(12.92f);
      gradient[i] = (F32(gain[c]) * slope * seen).v;
    }
  }
};

}  // namespace vitrine::blocks
