// Counter-based random numbers: a value depends on (seed, stream, counter) only, not on threads or time, so resumed runs and
// runs with other thread counts give the same bytes.
#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace vitrine {

// SplitMix64 finaliser (Steele et al. 2014): a bijection of 64 bits with full avalanche.
constexpr uint64_t mix64(uint64_t x) {
  x += 0x9e3779b97f4a7c15ull;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9ull;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebull;
  return x ^ (x >> 31);
}
constexpr uint64_t mix64(uint64_t a, uint64_t b) { return mix64(mix64(a) ^ (b * 0xd1342543de82ef95ull)); }

class Rng {
 public:
  // `stream` identifies purpose and item, e.g. Rng(seed, mix64(step, splat)).
  explicit Rng(uint64_t seed, uint64_t stream = 0) : key_(mix64(seed, stream)) {}

  uint64_t next_u64() { return mix64(key_, counter_++); }
  uint32_t next_u32() { return static_cast<uint32_t>(next_u64() >> 32); }
  uint32_t below(uint32_t n) { return static_cast<uint32_t>((static_cast<uint64_t>(next_u32()) * n) >> 32); }  // [0,n)
  float uniform() { return static_cast<float>(next_u64() >> 40) * 0x1p-24f; }                                 // [0,1)
  double uniform_double() { return static_cast<double>(next_u64() >> 11) * 0x1p-53; }
  // Box-Muller; always consumes two uniforms per value, so the counter advances by a fixed amount.
  float normal() {
    const double u1 = 1.0 - uniform_double(), u2 = uniform_double();
    return static_cast<float>(std::sqrt(-2.0 * std::log(u1)) * std::cos(2.0 * std::numbers::pi * u2));
  }

 private:
  uint64_t key_;
  uint64_t counter_ = 0;
};

}  // namespace vitrine
