// Albedo affinity: pairs of points that probably have the same albedo. Partners are neighbours of the same chromaticity, and
// points anywhere in the same chromaticity cluster (k-means). Light mainly changes brightness; paint changes brightness and
// chromaticity.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/foundation/math/vec.h"

namespace vitrine {

struct AffinityDesc {
  float radius = 0.1f;  // of the neighbourhood, scene units
  int clusters = 16;
  uint64_t seed = 1;
};

struct Affinity {
  struct Partner {
    uint32_t point;
    float weight;
  };
  std::vector<uint32_t> begin;  // [points + 1] into partners
  std::vector<Partner> partners;
  std::span<const Partner> of(size_t point) const { return {partners.data() + begin[point], begin[point + 1] - begin[point]}; }
};

Affinity affinity(std::span<const Vec3f> positions, std::span<const Vec3f> radiance, const AffinityDesc& desc);

}  // namespace vitrine
