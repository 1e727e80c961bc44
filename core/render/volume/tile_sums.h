// Sums over the rays of a tile, and from them the gradient of a Gaussian.
#pragma once

#include <array>
#include <cstring>
#include <span>

#include "core/render/volume/gaussian3.h"
#include "core/render/volume/volume_ray.h"

namespace vitrine {

using TileValues = std::array<float, RayTiles::kRays>;
using RayVectors = std::array<TileValues, 3>;  // [axis][ray]

// Eight partial sums, added in their order.
inline float sum_of_products(const TileValues& a, const TileValues& b) {
  constexpr size_t kLanes = 8;
  using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
  Lanes sum{};
  for (size_t begin = 0; begin < RayTiles::kRays; begin += kLanes) {
    Lanes x, y;
    std::memcpy(&x, &a[begin], sizeof x);
    std::memcpy(&y, &b[begin], sizeof y);
    sum += x * y;
  }
  float total = 0;
  for (size_t k = 0; k < kLanes; ++k) total += sum[k];
  return total;
}

inline float sum_of(const TileValues& a) {
  TileValues ones;
  ones.fill(1.f);
  return sum_of_products(a, ones);
}

// WhitenedGradient of one tile: offset, matrix by columns, log_density.
inline constexpr size_t kWhitenedSums = 13;
using WhitenedSums = std::array<float, kWhitenedSums>;

// `offset`: origin - mean; gradients by the whitened origins and directions of the rays. `log_density` is not set.
inline WhitenedSums whitened_sums(const RayTiles::Tile& tile, const RayVectors& offset, const RayVectors& of_origin,
                                  const RayVectors& of_direction) {
  WhitenedSums out{};
  for (size_t row = 0; row < 3; ++row) {
    out[row] = sum_of(of_origin[row]);
    for (size_t j = 0; j < 3; ++j)
      out[3 + 3 * j + row] = sum_of_products(offset[j], of_origin[row]) + sum_of_products(tile.direction[j], of_direction[row]);
  }
  return out;
}

inline Gaussian3Gradient gradient_of_sums(const Gaussian3f& gaussian, std::span<const double, kWhitenedSums> total) {
  const WhitenedGradient<double> white{
      {total[0], total[1], total[2]},
      {{total[3], total[4], total[5]}, {total[6], total[7], total[8]}, {total[9], total[10], total[11]}},
      total[12]};
  const Gaussian3d g = cast<double>(gaussian);
  return values_of(cast<float>(whitened_vjp(g, whitened(g), white)));
}

}  // namespace vitrine
