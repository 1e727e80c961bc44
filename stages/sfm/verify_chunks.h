// Which pairs of photos a verification process looks at together. RANSAC goes on until it has missed the best model with a
// probability of one in a thousand, if a quarter of the matches fit it (Fischler and Bolles 1981): thousands of draws for every
// pair of photos that have nothing in common, which is most of the time that verification takes. But of 20 matches 15 have to fit
// for a pair to count at all, and such a model is found in 150 draws. So pairs of similarly many matches go together, with the
// share of inliers that they cannot do without.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace vitrine {

struct VerifyChunk {
  std::vector<size_t> pairs;
  double inlier_ratio = 0.25;  // a pair with a smaller share of inliers would be dropped anyway; 0.25 is COLMAP's own
};

// `matches`: how many each pair has. Every pair is in one chunk; chunks depend on nothing but the arguments.
std::vector<VerifyChunk> verify_chunks(std::span<const size_t> matches, size_t min_inliers);

}  // namespace vitrine
