#include "core/train/photo_order.h"

#include <utility>

#include "core/base/rng.h"

namespace vitrine {

std::vector<uint32_t> photo_order(std::span<const uint32_t> photos, uint64_t seed, uint64_t epoch) {
  constexpr uint64_t kOrderStream = 0x7401;
  std::vector<uint32_t> order(photos.begin(), photos.end());
  Rng rng(seed, mix64(kOrderStream, epoch));
  for (size_t i = order.size() - 1; i > 0; --i) std::swap(order[i], order[rng.below(static_cast<uint32_t>(i + 1))]);
  return order;
}

}  // namespace vitrine
