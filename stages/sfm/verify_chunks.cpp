#include "stages/sfm/verify_chunks.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/parallel.h"

namespace vitrine {

namespace {

constexpr size_t kPairsPerChunk = 48;  // a process costs 20 ms to start; a pair takes up to 200
constexpr size_t kMaxChunks = 16;      // of a class
constexpr double kLeastRatio = 0.25;
constexpr double kClassWidth = 1.25;  // most matches of a class over its fewest

}  // namespace

std::vector<VerifyChunk> verify_chunks(std::span<const size_t> matches, size_t min_inliers) {
  const double fewest = double(std::max<size_t>(min_inliers, 1));
  const auto class_of = [&](double n) { return n > fewest ? static_cast<int>(std::log(n / fewest) / std::log(kClassWidth)) : 0; };
  const int last = class_of(fewest / kLeastRatio);  // from here on COLMAP's own share is the larger one
  std::map<int, std::vector<size_t>> classes;
  for (size_t i = 0; i < matches.size(); ++i) classes[std::min(last, class_of(double(matches[i])))].push_back(i);
  std::vector<VerifyChunk> chunks;
  for (const auto& [kind, members] : classes) {
    const double ratio = kind == last ? kLeastRatio : std::max(kLeastRatio, std::pow(kClassWidth, -(kind + 1)));
    const size_t count = std::min(kMaxChunks, chunk_count(members.size(), kPairsPerChunk));
    // Interleaved, so that every chunk has its share of overlapping pairs.
    for (size_t c = 0; c < count; ++c) {
      VerifyChunk chunk{.pairs = {}, .inlier_ratio = ratio};
      for (size_t i = c; i < members.size(); i += count) chunk.pairs.push_back(members[i]);
      chunks.push_back(std::move(chunk));
    }
  }
  return chunks;
}

}  // namespace vitrine
