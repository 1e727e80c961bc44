#include "stages/sfm/pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/base/rng.h"

namespace vitrine {
namespace {

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
        if (chunk.inlier_ratio > 0.25) EXPECT_GE(double(min_inliers), (chunk.inlier_ratio - 1e-9) * double(matches[i]));
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
