#include "core/trace/embree/space_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/parallel.h"

namespace vitrine::embree {

namespace {

constexpr size_t kChunk = 8192;  // surfels
constexpr int kAxisBits = 10;    // cells per axis of the curve: 1024
constexpr int kRadixBits = 10;   // of the 30 bits of a code per sorting pass
constexpr int kIndexBits = 32;

// Bits of a ten-bit number, two apart.
uint64_t spread(uint64_t x) {
  x = (x | x << 16) & 0x030000ff;
  x = (x | x << 8) & 0x0300f00f;
  x = (x | x << 4) & 0x030c30c3;
  return (x | x << 2) & 0x09249249;
}

}  // namespace

void SpaceOrder::build(const SplatLayer& layer) {
  const size_t n = layer.size();
  const std::span<const float> means = layer.values(Attribute::Mean);
  std::array<float, 3> low, high;
  low.fill(std::numeric_limits<float>::max());
  high.fill(std::numeric_limits<float>::lowest());
  for (size_t i = 0; i < means.size(); ++i) {
    if (!std::isfinite(means[i])) continue;
    low[i % 3] = std::min(low[i % 3], means[i]);
    high[i % 3] = std::max(high[i % 3], means[i]);
  }
  keys_.resize(n);
  sorted_.resize(n);
  parallel_chunks(n, kChunk, [&](size_t, size_t begin, size_t end) {
    constexpr float kCells = 1 << kAxisBits;
    for (size_t i = begin; i < end; ++i) {
      uint64_t code = 0;
      for (size_t c = 0; c < 3; ++c) {
        const float at = (means[3 * i + c] - low[c]) / (high[c] - low[c]) * kCells;
        code |= spread(at > 0.f ? static_cast<uint64_t>(std::min(at, kCells - 1.f)) : 0) << c;
      }
      keys_[i] = code << kIndexBits | i;
    }
  });
  for (int shift = kIndexBits; shift < kIndexBits + 3 * kAxisBits; shift += kRadixBits) {
    std::array<uint32_t, 1 << kRadixBits> at{};
    const auto digit = [&](uint64_t key) { return key >> shift & ((1u << kRadixBits) - 1); };
    for (const uint64_t key : keys_) ++at[digit(key)];
    uint32_t next = 0;
    for (uint32_t& a : at) next += std::exchange(a, next);
    for (const uint64_t key : keys_) sorted_[at[digit(key)]++] = key;
    keys_.swap(sorted_);
  }
  surfel_at.resize(n);
  place_of.resize(n);
  for (size_t i = 0; i < n; ++i) {
    surfel_at[i] = static_cast<uint32_t>(keys_[i]);
    place_of[surfel_at[i]] = static_cast<uint32_t>(i);
  }
}

}  // namespace vitrine::embree
