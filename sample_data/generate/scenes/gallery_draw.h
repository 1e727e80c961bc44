// What a seed of the gallery decides: numbers, choices and colours, one after another from one stream.
#pragma once

#include <span>
#include <utility>
#include <vector>

#include "core/foundation/base/rng.h"
#include "sample_data/generate/paint.h"

namespace vitrine::generate {

class Draw {
 public:
  Draw(uint64_t seed, uint64_t purpose) : rng_(seed, mix64(0x9a11e57, purpose)) {}

  float between(float low, float high) { return low + (high - low) * rng_.uniform(); }
  int whole(int low, int high) {
    return low + static_cast<int>(rng_.below(static_cast<uint32_t>(high - low + 1)));
  }  // [low,high]
  bool chance(float p) { return rng_.uniform() < p; }
  uint32_t texture_seed() { return rng_.next_u32() >> 8; }
  template <class T>
  const T& pick(const std::vector<T>& from) {
    return from[rng_.below(static_cast<uint32_t>(from.size()))];
  }
  template <class T>
  void shuffle(std::span<T> items) {  // Fisher-Yates
    for (size_t i = items.size(); i > 1; --i) std::swap(items[i - 1], items[rng_.below(static_cast<uint32_t>(i))]);
  }

 private:
  Rng rng_;
};

}  // namespace vitrine::generate
