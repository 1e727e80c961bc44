// In which order an epoch looks at its photos: a permutation that depends on seed and epoch alone, so that a run that continues
// needs no memory of it.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace vitrine {

std::vector<uint32_t> photo_order(std::span<const uint32_t> photos, uint64_t seed, uint64_t epoch);

}  // namespace vitrine
