// Which photos are compared. Up to `exhaustive_limit` photos: all pairs. Above: neighbours in name order (sequence), at distances
// 1..window and then doubling distances (loops of a long walk), and for every photo its nearest ones by a global descriptor:
// VLAD (Jegou et al. 2010) over the photos' own SIFT descriptors, with a vocabulary learnt from the same photos; no file to
// download.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "stages/sfm/database.h"

namespace vitrine {

struct PairRules {
  int exhaustive_limit = 80;
  int window = 10;
  int retrieved = 20;  // nearest photos by appearance, per photo
  uint64_t seed = 0;
};

using PhotoPair = std::pair<uint32_t, uint32_t>;  // indices into the photo list, first < second

std::vector<PhotoPair> candidate_pairs(std::span<const PhotoFeatures> photos, const PairRules& rules);
// For every photo its `count` nearest others, best first.
std::vector<std::vector<uint32_t>> nearest_by_appearance(std::span<const PhotoFeatures> photos, int count, uint64_t seed);

}  // namespace vitrine
