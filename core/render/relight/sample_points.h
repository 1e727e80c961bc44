// Low-discrepancy points in the unit square: the first two dimensions of the Sobol sequence. Any 2^k consecutive points place one
// point in every elementary interval of area 2^-k. Owen scrambling by a hash of the higher digits (Laine and Karras 2011); each
// plane permutes the order of the points (Burley 2020), which decorrelates planes and pixels. A point depends on (seed, stream,
// plane, sample) only.
#pragma once

#include "core/foundation/base/rng.h"
#include "core/foundation/math/vec.h"

namespace vitrine {

class SamplePoints {
 public:
  // `stream`: index of the pixel or vertex.
  SamplePoints(uint64_t seed, uint64_t stream) : key_(mix64(seed, stream)) {}

  Vec2f point(uint32_t plane, uint32_t sample) const {
    const uint64_t a = mix64(key_, plane), b = mix64(a);
    const uint32_t i = reversed(scrambled(reversed(sample), static_cast<uint32_t>(a)));
    return {unit(scrambled(i, static_cast<uint32_t>(a >> 32))), unit(scrambled(pascal(i), static_cast<uint32_t>(b)))};
  }

 private:
  // From bit-reversed digits.
  static float unit(uint32_t digits) { return static_cast<float>(reversed(digits) >> 8) * 0x1p-24f; }
  static uint32_t reversed(uint32_t i) {
    i = (i << 16) | (i >> 16);
    i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
    i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
    i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
    return ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
  }
  // Owen scrambling: a permutation in which each bit depends on the lower bits and the seed.
  static uint32_t scrambled(uint32_t x, uint32_t seed) {
    x += seed;
    x ^= x * 0x6c50b47cu;
    x ^= x * 0xb82f1e52u;
    x ^= x * 0xc7afe638u;
    return x ^ (x * 0x8d22f6e6u);
  }
  // Multiplies by the Pascal matrix modulo 2, the generator matrix of the second dimension, as five shears.
  static uint32_t pascal(uint32_t x) {
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    return x ^ ((x & 0xffff0000u) >> 16);
  }

  uint64_t key_;
};

}  // namespace vitrine
