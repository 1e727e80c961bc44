// Spherical harmonics of a layer laid out for rays: [k][rgb_], two coefficients to a vector of eight floats, so that the colour
// of a hit is a handful of multiply-adds with the basis of its ray, which is spread in the same way once per ray.
#pragma once

#include <vector>

#include "core/base/parallel.h"
#include "core/render/kernels/shade.h"
#include "core/scene/layers.h"

namespace vitrine::embree {

typedef float F4 __attribute__((vector_size(16)));
typedef float F8 __attribute__((vector_size(32)));

inline constexpr size_t kMaxPairs = (kMaxShCoefficients + 1) / 2;
constexpr size_t pair_count(int degree) { return (sh_coefficient_count(degree) + 1) / 2; }

struct SpreadBasis {
  F8 pairs[kMaxPairs];
  float values[kMaxShCoefficients];
  size_t count;  // pairs in use
};

inline SpreadBasis spread_basis(int degree, const Vec3f& direction) {
  SpreadBasis b{};
  sh_basis(degree, direction, b.values);
  b.count = pair_count(degree);
  for (size_t k = 0; k < sh_coefficient_count(degree); ++k)
    for (size_t c = 0; c < 3; ++c) b.pairs[k / 2][4 * (k % 2) + c] = b.values[k];
  return b;
}

inline F4 folded(F8 v) { return F4{v[0] + v[4], v[1] + v[5], v[2] + v[6], v[3] + v[7]}; }

class PackedColors {
 public:
  void build(const SplatLayer& layer) {
    pairs_ = pair_count(layer.sh_degree());
    data_.resize(layer.size() * pairs_);
    const size_t rest = layer.width(Attribute::ShRest);
    parallel_chunks(layer.size(), kChunk, [&](size_t, size_t begin, size_t end) {
      for (size_t i = begin; i < end; ++i) {
        F8* to = data_.data() + i * pairs_;
        std::fill(to, to + pairs_, F8{});
        const float *dc = layer.at(Attribute::ShDc, i), *higher = layer.at(Attribute::ShRest, i);
        for (size_t c = 0; c < 3; ++c) to[0][c] = dc[c];
        for (size_t j = 0; j < rest; ++j) to[(j / 3 + 1) / 2][4 * ((j / 3 + 1) % 2) + j % 3] = higher[j];
      }
    });
  }
  const F8* of(uint32_t surfel) const { return data_.data() + surfel * pairs_; }

  Vec3f color(uint32_t surfel, const SpreadBasis& basis) const {
    const F8* h = of(surfel);
    F8 even = basis.pairs[0] * h[0], odd{};
    for (size_t p = 1; p < basis.count; p += 2) {
      odd += basis.pairs[p] * h[p];
      if (p + 1 < basis.count) even += basis.pairs[p + 1] * h[p + 1];
    }
    const F4 sum = folded(even + odd) + 0.5f;
    return {sum[0] > 0.f ? sum[0] : 0.f, sum[1] > 0.f ? sum[1] : 0.f, sum[2] > 0.f ? sum[2] : 0.f};
  }

 private:
  static constexpr size_t kChunk = 4096;  // surfels
  size_t pairs_ = 0;
  std::vector<F8> data_;
};

}  // namespace vitrine::embree
