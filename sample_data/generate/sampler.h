// Low-discrepancy points for one sample of one pixel: pairs of a (0,2)-sequence (van der Corput, second Sobol dimension), each
// pair shuffled and Owen-scrambled with its own hash (Burley 2020, "Practical Hash-based Owen Scrambling"). A value depends on
// (key, sample, dimension) alone, so pictures have the same bytes for any number of threads.
#pragma once

#include <cstdint>

#include "core/foundation/base/rng.h"
#include "core/foundation/math/vec.h"

namespace vitrine::generate {

constexpr uint32_t reversed_bits(uint32_t x) {
  x = (x << 16) | (x >> 16);
  x = ((x & 0x00ff00ffu) << 8) | ((x & 0xff00ff00u) >> 8);
  x = ((x & 0x0f0f0f0fu) << 4) | ((x & 0xf0f0f0f0u) >> 4);
  x = ((x & 0x33333333u) << 2) | ((x & 0xccccccccu) >> 2);
  return ((x & 0x55555555u) << 1) | ((x & 0xaaaaaaaau) >> 1);
}

// Owen scrambling in base 2: the Laine-Karras hash on reversed bits, with the constants of Burley's paper.
constexpr uint32_t owen_scrambled(uint32_t x, uint32_t seed) {
  x = reversed_bits(x) + seed;
  x ^= x * 0x6c50b47cu;
  x ^= x * 0xb82f1e52u;
  x ^= x * 0xc7afe638u;
  x ^= x * 0x8d22f6e6u;
  return reversed_bits(x);
}

constexpr uint32_t sobol_second(uint32_t index) {
  uint32_t result = 0;
  for (uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
    if (index & 1u) result ^= v;
  return result;
}

class Sampler {
 public:
  Sampler(uint64_t key, uint32_t sample) : key_(key), sample_(sample) {}

  Vec2f pair() {
    const uint64_t seed = mix64(key_, dimension_++);
    const uint32_t shuffled = owen_scrambled(sample_, static_cast<uint32_t>(seed));
    const uint32_t x = owen_scrambled(reversed_bits(shuffled), static_cast<uint32_t>(seed >> 32));
    const uint32_t y = owen_scrambled(sobol_second(shuffled), static_cast<uint32_t>(mix64(seed)));
    return {static_cast<float>(x >> 8) * 0x1p-24f, static_cast<float>(y >> 8) * 0x1p-24f};
  }
  float single() { return pair().x; }

 private:
  uint64_t key_;
  uint32_t sample_;
  uint64_t dimension_ = 0;
};

}  // namespace vitrine::generate
