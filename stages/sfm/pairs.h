// Selection of the photo pairs to match. Up to `exhaustive_limit` photos: all pairs. Above: neighbours in name order (sequence)
// at distances 1..window and then doubling distances (loop closure), and for every photo its nearest neighbours by a global
// descriptor: VLAD (Jegou et al. 2010) over the SIFT descriptors, with a vocabulary learnt from the same photos, so no download
// is needed. Also splits the pairs into chunks for the geometric verification.
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
  std::span<const size_t> rig = {};  // [photo] photos of one rig have one centre and are not paired; empty: none has
  bool same_rig(size_t a, size_t b) const { return !rig.empty() && rig[a] == rig[b]; }
};

using PhotoPair = std::pair<uint32_t, uint32_t>;  // indices into the photo list, first < second

std::vector<PhotoPair> candidate_pairs(std::span<const PhotoFeatures> photos, const PairRules& rules);
// For every photo its `retrieved` nearest neighbours of other rigs, best first.
std::vector<std::vector<uint32_t>> nearest_by_appearance(std::span<const PhotoFeatures> photos, const PairRules& rules);

// Pairs for one process of the geometric verification. RANSAC runs until it has missed the best model with probability 1/1000,
// assuming a quarter of the matches are inliers (Fischler and Bolles 1981): thousands of samples for each unrelated pair, which
// is most of the verification time. But a pair with 20 matches needs 15 inliers to count at all, and 150 samples find such a
// model. So each chunk groups pairs with similar match counts and uses the smallest inlier ratio that they need.
struct VerifyChunk {
  std::vector<size_t> pairs;
  double inlier_ratio = 0.25;  // a pair with a smaller ratio is dropped anyway; 0.25 is COLMAP's default
};

// `matches`: match count of each pair. Every pair is in exactly one chunk. Deterministic.
std::vector<VerifyChunk> verify_chunks(std::span<const size_t> matches, size_t min_inliers);

}  // namespace vitrine
