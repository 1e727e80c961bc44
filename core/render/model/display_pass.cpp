#include "core/render/model/composite_pass.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/color.h"

namespace vitrine {

namespace {

constexpr size_t kDisplayGrain = 8192;

// The sRGB transfer function above its knee is 1.055 l^(1/2.4) - 0.055, and l^(1/2.4) = t^(5/3) with t = l^(1/4): two square
// roots and a polynomial in t, scaled to [-1, 1] over [knee^(1/4), 1] (Chebyshev nodes, |error| < 6e-7 in float).
inline float display_value(float l) {
  const float u = 2.6196699f * std::sqrt(std::sqrt(l)) - 1.6196699f;
  float p = -8.03033181e-05f;
  p = p * u + 2.00126684e-4f;
  p = p * u - 3.89319408e-4f;
  p = p * u + 1.374154e-3f;
  p = p * u - 6.88124588e-3f;
  p = p * u + 0.100260653f;
  p = p * u + 0.487126082f;
  p = p * u + 0.418389678f;
  return l > kSrgbKnee ? p : 12.92f * l;
}
// Its derivative at l, given its value there.
inline float display_slope(float l, float value) {
  return l > kSrgbKnee ? (value + 0.055f) / (2.4f * std::max(l, kSrgbKnee)) : 12.92f;
}

// Calls body(begin, end, gain) for chunks of the three planes.
template <class Body>
void for_pieces(const Frame& frame, const Body& body) {
  const size_t pixels = frame.pixel_count();
  for (size_t c = 0; c < 3; ++c) {
    const float gain = static_cast<float>(frame.view->gain[c]);
    parallel_chunks(pixels, kDisplayGrain,
                    [&](size_t, size_t begin, size_t end) { body(c * pixels + begin, c * pixels + end, gain); });
  }
}

}  // namespace

void DisplayPass::forward(const SplatScene&, Frame& frame) {
  frame.srgb.resize(frame.linear.size());
  frame.grad_srgb.resize(frame.linear.size());
  for_pieces(frame, [&](size_t begin, size_t end, float gain) {
    const float* __restrict linear = frame.linear.data();
    float* __restrict srgb = frame.srgb.data();
    for (size_t i = begin; i < end; ++i) srgb[i] = display_value(std::min(std::max(gain * linear[i], 0.f), 1.f));
    std::fill(frame.grad_srgb.data() + begin, frame.grad_srgb.data() + end, 0.f);
  });
}

void DisplayPass::backward(const SplatScene&, Frame& frame, SplatScene&) {
  frame.grad_linear.resize(frame.linear.size());
  for_pieces(frame, [&](size_t begin, size_t end, float gain) {
    const float* __restrict linear = frame.linear.data();
    const float* __restrict srgb = frame.srgb.data();
    const float* __restrict grad = frame.grad_srgb.data();
    float* __restrict out = frame.grad_linear.data();
    for (size_t i = begin; i < end; ++i) {
      const float l = gain * linear[i], g = grad[i];
      // The gradient of a clipped value only moves it back into range.
      const float seen = l > 1.f ? std::max(g, 0.f) : l < 0.f ? std::min(g, 0.f) : g;
      out[i] = seen * gain * display_slope(std::min(std::max(l, 0.f), 1.f), srgb[i]);
    }
  });
}

}  // namespace vitrine
