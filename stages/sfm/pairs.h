// Which photos are compared. Up to `exhaustive_limit` photos: all pairs. Above: neighbours in name order (sequence), at distances
// 1..window and then doubling distances (loops of a long walk), and for every photo its nearest ones by a global descriptor:
// VLAD (Jegou et al. 2010) over the photos' own SIFT descriptors, with a vocabulary learnt from the same photos; no file to
// download. And which of them a process of the geometric verification looks at.
#pragma once

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "stages/sfm/database.h"

namespace vitrine {

struct PairRules {
  int exhaustive_limit = 80;
  int window = 10;     // above the limit: neighbours in name order
  int retrieved = 20;  // above the limit: nearest photos by appearance, per photo
  uint64_t seed = 0;
};

using PhotoPair = std::pair<uint32_t, uint32_t>;  // indices into the photo list, first < second

std::vector<PhotoPair> candidate_pairs(std::span<const PhotoFeatures> photos, const PairRules& rules);
// For every photo its `count` nearest others, best first.
std::vector<std::vector<uint32_t>> nearest_by_appearance(std::span<const PhotoFeatures> photos, int count, uint64_t seed);

// Pairs that one process of the geometric verification looks at. RANSAC goes on until it has missed the best model with a
// probability of one in a thousand, if a quarter of the matches fit it (Fischler and Bolles 1981): thousands of draws for every
// pair of photos that have nothing in common, which is most of the time that verification takes. But of 20 matches 15 have to fit
// for a pair to count at all, and such a model is found in 150 draws. So pairs of similarly many matches go together, with the
// share of inliers that they cannot do without.
struct VerifyChunk {
  std::vector<size_t> pairs;
  double inlier_ratio = 0.25;  // a pair with a smaller share of inliers would be dropped anyway; 0.25 is COLMAP's own
};

// `matches`: how many each pair has. Every pair is in one chunk; chunks depend on nothing but the arguments.
std::vector<VerifyChunk> verify_chunks(std::span<const size_t> matches, size_t min_inliers);

}  // namespace vitrine
