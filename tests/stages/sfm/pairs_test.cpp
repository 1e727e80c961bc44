#include "stages/sfm/pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "stages/sfm/matcher.h"

namespace vitrine {
namespace {

// `places` places, photographed in turn: photo i shows place i % places, so neighbours in name order never overlap.
std::vector<PhotoFeatures> photos_of_places(size_t n, size_t places) {
  std::vector<PhotoFeatures> out(n);
  for (size_t i = 0; i < n; ++i) {
    constexpr size_t kFeatures = 60;
    out[i].count = kFeatures;
    out[i].descriptors.resize(kFeatures * kDescriptorBytes);
    for (size_t f = 0; f < kFeatures; ++f) {
      Rng shape(11, mix64(i % places, f)), noise(12, mix64(i, f));
      for (size_t k = 0; k < kDescriptorBytes; ++k) {
        const uint32_t base = shape.below(10) < 3 ? shape.below(140) : shape.below(12);
        out[i].descriptors[f * kDescriptorBytes + k] = static_cast<uint8_t>(base + noise.below(15));
      }
    }
  }
  return out;
}

TEST(CandidatePairs, AreAllPairsOfASmallSet) {
  EXPECT_EQ(candidate_pairs(photos_of_places(12, 3), {}).size(), 66u);
  EXPECT_TRUE(candidate_pairs(photos_of_places(1, 1), {}).empty());
}

TEST(CandidatePairs, AboveTheLimitHoldSequenceLoopsAndLookAlikes) {
  const std::vector<PhotoFeatures> photos = photos_of_places(60, 12);
  const PairRules rules{.exhaustive_limit = 30, .window = 3, .retrieved = 4};
  const std::vector<PhotoPair> pairs = candidate_pairs(photos, rules);
  const std::set<PhotoPair> set(pairs.begin(), pairs.end());
  EXPECT_EQ(set.size(), pairs.size());
  EXPECT_LT(pairs.size(), 60u * 59u / 4u);
  for (uint32_t a = 0; a < 60; ++a) {
    for (uint32_t step : {1u, 2u, 3u, 6u, 12u, 24u}) {
      if (a + step < 60) {
        EXPECT_TRUE(set.contains({a, a + step})) << a << " + " << step;
      }
    }
  }
  // Each photo's four look-alikes are exactly the four others of its place.
  const auto nearest = nearest_by_appearance(photos, {.retrieved = 4});
  for (uint32_t a = 0; a < 60; ++a)
    for (uint32_t b : nearest[a]) EXPECT_EQ(a % 12, b % 12);
}

TEST(CandidatePairs, OfOneRigAreNoneAndThoseOfTheNextRigAreNeighbours) {
  constexpr uint32_t kOfRig = 10;
  std::vector<PhotoFeatures> photos = photos_of_places(60, 12);
  std::vector<size_t> rig;
  for (uint32_t i = 0; i < 60; ++i) rig.push_back(i / kOfRig);
  for (const int limit : {10, 100}) {
    const std::vector<PhotoPair> pairs = candidate_pairs(photos, {.exhaustive_limit = limit, .window = 10, .retrieved = 5, .rig = rig});
    EXPECT_TRUE(std::ranges::none_of(pairs, [&](const PhotoPair& p) { return rig[p.first] == rig[p.second]; }));
    for (uint32_t a = 0; a < kOfRig; ++a)
      for (uint32_t b = kOfRig; b < 2 * kOfRig; ++b) EXPECT_TRUE(std::ranges::binary_search(pairs, PhotoPair{a, b}));
  }
}

TEST(CandidatePairs, DoNotDependOnThreads) {
  const std::vector<PhotoFeatures> photos = photos_of_places(40, 7);
  const PairRules rules{.exhaustive_limit = 10, .window = 2, .retrieved = 5, .seed = 3};
  set_thread_limit(1);
  const std::vector<PhotoPair> one = candidate_pairs(photos, rules);
  set_thread_limit(2);
  EXPECT_EQ(candidate_pairs(photos, rules), one);
  set_thread_limit(0);
}

TEST(CandidatePairs, SurvivePhotosWithoutFeatures) {
  std::vector<PhotoFeatures> photos = photos_of_places(12, 3);
  photos[4] = {};
  EXPECT_GE(candidate_pairs(photos, {.exhaustive_limit = 5, .window = 1, .retrieved = 2}).size(), 11u);
  EXPECT_GE(candidate_pairs(std::vector<PhotoFeatures>(9), {.exhaustive_limit = 5, .window = 1, .retrieved = 2}).size(), 8u);
}

TEST(VerifyChunks, EveryPairOnceAndNoneLosesWhatWouldCount) {
  for (size_t min_inliers : {1, 6, 15, 40}) {
    std::vector<size_t> matches{min_inliers, min_inliers + 1, 4 * min_inliers, 100 * min_inliers};
    Rng rng(5, min_inliers);
    for (int i = 0; i < 3000; ++i) matches.push_back(min_inliers + rng.below(uint32_t(12 * min_inliers)));
    std::vector<int> times(matches.size());
    for (const VerifyChunk& chunk : verify_chunks(matches, min_inliers)) {
      ASSERT_FALSE(chunk.pairs.empty());
      EXPECT_GE(chunk.inlier_ratio, 0.25);
      EXPECT_LT(chunk.inlier_ratio, 1);
      for (size_t i : chunk.pairs) {
        ++times[i];
        // As many inliers as make the pair count are at least the share that is looked for ...
        if (chunk.inlier_ratio > 0.25) {
          EXPECT_GE(double(min_inliers), (chunk.inlier_ratio - 1e-9) * double(matches[i]));
        }
        // ... and not much more than it, or time is wasted.
        EXPECT_LT(double(min_inliers), 1.6 * chunk.inlier_ratio * double(matches[i]) + 1e-9);
      }
    }
    EXPECT_TRUE(std::ranges::all_of(times, [](int n) { return n == 1; }));
  }
  EXPECT_TRUE(verify_chunks({}, 15).empty());
}

TEST(VerifyChunks, ManyPairsAreManyChunksOfSimilarSize) {
  const std::vector<size_t> alike(1000, 30);
  const auto chunks = verify_chunks(alike, 15);
  ASSERT_EQ(chunks.size(), 16u);
  for (const VerifyChunk& chunk : chunks) EXPECT_NEAR(double(chunk.pairs.size()), 62.5, 1);
}

}  // namespace
}  // namespace vitrine
