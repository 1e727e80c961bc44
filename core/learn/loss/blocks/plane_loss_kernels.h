// Losses of the planes of a forward pass (normal_consistency.cpp, distortion.cpp) and of raw values of surfels
// (surfel_regularisers.cpp) as kernels for a GPU. A kernel adds to the gradients of its own pixel or surfel alone.
#pragma once

#include "core/learn/loss/normal_kernel.h"
#include "core/render/raster/blocks/block_kernel.h"
#include "core/render/raster/blocks/f32.h"
#include "core/scene/surfels/activation.h"

namespace vitrine::blocks {

// to[i] = value.
struct FillKernel {
  static constexpr uint32_t kThreads = 256;
  using Shared = NoShared;
  using Thread = NoThread;
  float* to;
  float value;
  size_t size;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const size_t i = size_t{at.block} * kThreads + at.thread;
    if (i < size) to[i] = value;
  }
};

// Three planes [h,w].
template <class T>
struct Planes3 {
  T* plane[3];
  VITRINE_HD Vec3<F32> at(size_t i) const { return {F32(plane[0][i]), F32(plane[1][i]), F32(plane[2][i])}; }
  VITRINE_HD void add(size_t i, const Vec3<F32>& v) const {
    for (size_t c = 0; c < 3; ++c) plane[c][i] = (F32(plane[c][i]) + v[c]).v;
  }
};

// The surface that a picture shows: points of the mean depth in the camera frame.
struct DepthSurface {
  const float *zdepth, *alpha;  // [h,w]
  float fx, fy, cx, cy;
  uint32_t width, height;
  VITRINE_HD uint32_t pixels() const { return width * height; }
  VITRINE_HD bool inside(uint32_t x, uint32_t y) const { return x > 0 && y > 0 && x + 1 < width && y + 1 < height; }
  // 0: the pixel has none.
  VITRINE_HD F32 depth(uint32_t i) const { return alpha[i] < kLeastAlphaOfDepth ? F32(0.f) : F32(zdepth[i]) / F32(alpha[i]); }
  VITRINE_HD Vec3<F32> ray(uint32_t x, uint32_t y) const {
    return {(F32(static_cast<float>(x)) + F32(0.5f) - F32(cx)) / F32(fx),
            (F32(static_cast<float>(y)) + F32(0.5f) - F32(cy)) / F32(fy), F32(1.f)};
  }
};

// A thread for each pixel: the term of normal consistency, its gradient by the normal, and those by the central differences of
// the surface down and right, [3,h,w] each; zero where there is no term.
struct NormalConsistencyKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  DepthSurface surface;
  Planes3<const float> normal;
  Mat3<F32> cam_from_world;
  float factor;  // of the gradients
  Planes3<float> grad_normal, grad_down, grad_right;
  float* value;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread, width = surface.width;
    if (i >= surface.pixels()) return;
    value[i] = 0.f;
    for (size_t c = 0; c < 3; ++c) grad_down.plane[c][i] = grad_right.plane[c][i] = 0.f;
    const uint32_t x = i % width, y = i / width;
    if (!surface.inside(x, y) || !(surface.depth(i) > F32(0.f))) return;
    const F32 up = surface.depth(i - width), down = surface.depth(i + width), left = surface.depth(i - 1),
              right = surface.depth(i + 1);
    if (!(min(min(up, down), min(left, right)) > F32(0.f))) return;
    const Vec3<F32> a = down * surface.ray(x, y + 1) - up * surface.ray(x, y - 1);
    const Vec3<F32> b = right * surface.ray(x + 1, y) - left * surface.ray(x - 1, y);
    const NormalTerm<F32> term = normal_term(cam_from_world * normal.at(i), a, b, F32(surface.alpha[i]));
    value[i] = term.value.v;
    const F32 step(factor);
    grad_normal.add(i, step * transposed_times(cam_from_world, term.grad_normal));
    grad_down.add(i, step * term.grad_a);
    grad_right.add(i, step * term.grad_b);
  }
};

// Adds the gradients by the differences of the four neighbours to those of the pixel's depth.
struct DepthGradientKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  DepthSurface surface;
  Planes3<const float> grad_down, grad_right;
  float *grad_zdepth, *grad_alpha;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread, width = surface.width;
    if (i >= surface.pixels() || !(surface.depth(i) > F32(0.f))) return;
    const uint32_t x = i % width, y = i / width;
    Vec3<F32> g{F32(0.f), F32(0.f), F32(0.f)};
    if (y > 0) g += grad_down.at(i - width);
    if (y + 1 < surface.height) g -= grad_down.at(i + width);
    if (x > 0) g += grad_right.at(i - 1);
    if (x + 1 < width) g -= grad_right.at(i + 1);
    const F32 slope = dot(g, surface.ray(x, y)), z(surface.zdepth[i]), alpha(surface.alpha[i]);
    grad_zdepth[i] = (F32(grad_zdepth[i]) + slope / alpha).v;
    grad_alpha[i] = (F32(grad_alpha[i]) - slope * z / (alpha * alpha)).v;
  }
};

// A thread for each raw value: its activated value, exp or sigmoid, and the gradient of `factor` times it, which is added.
template <bool kSigmoid>
struct ActivationKernel {
  static constexpr uint32_t kThreads = 128;
  using Shared = NoShared;
  using Thread = NoThread;
  const float* raw;
  float factor;
  float *gradient, *value;
  uint32_t count;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    const uint32_t i = at.block * kThreads + at.thread;
    if (i >= count) return;
    F32 v(raw[i]), slope;
    if constexpr (kSigmoid) {
      v = sigmoid(v);
      slope = v * (F32(1.f) - v);
    } else {
      v = slope = exp(v);
    }
    value[i] = v.v;
    gradient[i] = (F32(gradient[i]) + F32(factor) * slope).v;
  }
};

}  // namespace vitrine::blocks
