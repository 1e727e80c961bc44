// Spherical harmonics of a layer in a layout for rays: red, green and blue coefficients consecutively, padded to fours, so that
// the colour of a hit is three short dot products with the basis of its ray, and degree 3 fills three cache lines exactly.
#pragma once

#include <immintrin.h>

#include <algorithm>
#include <span>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/plain_array.h"
#include "core/render/raster/kernels/shade.h"
#include "core/scene/surfels/layers.h"

namespace vitrine::embree {

typedef float F4 __attribute__((vector_size(16)));

inline constexpr size_t kMaxFours = kMaxShCoefficients / 4;
constexpr size_t fours(int degree) { return (sh_coefficient_count(degree) + 3) / 4; }

struct RayBasis {
  F4 y[kMaxFours];  // zero after the last coefficient
  size_t count;     // of fours in use
};

inline RayBasis ray_basis(int degree, const Vec3f& direction) {
  float values[kMaxShCoefficients] = {};
  sh_basis(degree, direction, values);
  RayBasis b;
  b.count = fours(degree);
  for (size_t k = 0; k < kMaxFours; ++k) b.y[k] = F4{values[4 * k], values[4 * k + 1], values[4 * k + 2], values[4 * k + 3]};
  return b;
}

class PackedColors {
 public:
  // Stores the colours of surfel order[place] at `place`.
  void build(const SplatLayer& layer, std::span<const uint32_t> order) {
    stride_ = fours(layer.sh_degree());
    data_.resize(layer.size() * 3 * stride_);
    const size_t coefficients = sh_coefficient_count(layer.sh_degree());
    parallel_chunks(layer.size(), kChunk, [&](size_t, size_t begin, size_t end) {
      for (size_t place = begin; place < end; ++place) {
        const size_t i = order[place];
        const float *dc = layer.at(Attribute::ShDc, i), *rest = layer.at(Attribute::ShRest, i);
        for (size_t c = 0; c < 3; ++c) {
          F4* to = data_.data() + (3 * place + c) * stride_;
          std::fill(to, to + stride_, F4{});
          to[0][0] = dc[c];
          for (size_t k = 1; k < coefficients; ++k) to[k / 4][k % 4] = rest[3 * (k - 1) + c];
        }
      }
    });
  }
  // Coefficients of one channel.
  const F4* of(size_t place, size_t channel) const { return data_.data() + (3 * place + channel) * stride_; }

  // The colours of hits are far apart in memory: prefetch them as soon as the hits are known.
  void prefetch(size_t place) const {
    const char *line = reinterpret_cast<const char*>(of(place, 0)), *end = reinterpret_cast<const char*>(of(place + 1, 0));
    for (; line < end; line += 64) __builtin_prefetch(line);
  }

  // max(0, 0.5 + Y.h), the ray_color of kernels/march.h.
  Vec3f color(size_t place, const RayBasis& basis) const {
    F4 sum[3];
    for (size_t c = 0; c < 3; ++c) {
      const F4* h = of(place, c);
      sum[c] = basis.y[0] * h[0];
      for (size_t k = 1; k < basis.count; ++k) sum[c] += basis.y[k] * h[k];
    }
    const F4 rgb = _mm_hadd_ps(_mm_hadd_ps(sum[0], sum[1]), _mm_hadd_ps(sum[2], sum[2])) + 0.5f;
    const F4 value = _mm_max_ps(rgb, _mm_setzero_ps());
    return {value[0], value[1], value[2]};
  }

 private:
  static constexpr size_t kChunk = 4096;  // surfels
  size_t stride_ = 0;                     // fours per channel
  PlainArray<F4, Pages::Huge> data_;
};

}  // namespace vitrine::embree
