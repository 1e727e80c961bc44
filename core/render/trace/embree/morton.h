// Morton order (space-filling curve): points near in space get near positions in memory or in time.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine::embree {

// Cells of a cube grid of 2^bits per axis around a set of points; points that are not finite are in the first cell.
class MortonGrid {
 public:
  MortonGrid(std::span<const Vec3f> points, int bits) : cells_(static_cast<float>(1 << bits)) {
    for (const Vec3f& p : points)
      for (size_t c = 0; c < 3; ++c) {
        if (!std::isfinite(p[c])) continue;
        low_[c] = p[c] < low_[c] ? p[c] : low_[c];
        high_[c] = p[c] > high_[c] ? p[c] : high_[c];
      }
  }
  // 3 * bits bits.
  uint32_t code(const Vec3f& p) const {
    uint32_t code = 0;
    for (size_t c = 0; c < 3; ++c) {
      const float at = (p[c] - low_[c]) / (high_[c] - low_[c]) * cells_;
      code |= spread(at > 0.f ? static_cast<uint32_t>(at < cells_ ? at : cells_ - 1.f) : 0u) << c;
    }
    return code;
  }

 private:
  // Spreads the bits of a ten-bit number, with two zero bits in between.
  static uint32_t spread(uint32_t x) {
    x = (x | x << 16) & 0x030000ff;
    x = (x | x << 8) & 0x0300f00f;
    x = (x | x << 4) & 0x030c30c3;
    return (x | x << 2) & 0x09249249;
  }
  float cells_;
  Vec3f low_{kMost, kMost, kMost}, high_{-kMost, -kMost, -kMost};
  static constexpr float kMost = std::numeric_limits<float>::max();
};

// order[i] = index of the i-th smallest code, equal ones by index. Codes have `bits` bits.
inline void order_by_code(std::span<const uint32_t> codes, int bits, std::vector<uint32_t>& order) {
  constexpr int kRadixBits = 10;
  std::vector<uint64_t> keys(codes.size()), sorted(codes.size());
  for (size_t i = 0; i < codes.size(); ++i) keys[i] = static_cast<uint64_t>(codes[i]) << 32 | i;
  for (int shift = 32; shift < 32 + bits; shift += kRadixBits) {
    std::array<uint32_t, 1 << kRadixBits> at{};
    const auto digit = [&](uint64_t key) { return key >> shift & ((1u << kRadixBits) - 1); };
    for (const uint64_t key : keys) ++at[digit(key)];
    uint32_t next = 0;
    for (uint32_t& a : at) next += std::exchange(a, next);
    for (const uint64_t key : keys) sorted[at[digit(key)]++] = key;
    keys.swap(sorted);
  }
  order.resize(codes.size());
  for (size_t i = 0; i < codes.size(); ++i) order[i] = static_cast<uint32_t>(keys[i]);
}

}  // namespace vitrine::embree
