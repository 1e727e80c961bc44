#include "stages/sfm/pairs.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "stages/sfm/matcher.h"

namespace vitrine {

namespace {

constexpr size_t kWords = 64;                // vocabulary size: 64 x 128 floats describe a photo
constexpr size_t kSamplesPerPhoto = 200;     // for learning the vocabulary
constexpr size_t kDescribedPerPhoto = 2000;  // the first, coarsest features: enough for VLAD
constexpr int kLearningRounds = 8;

constexpr size_t kPairsPerChunk = 48;  // a process takes 20 ms to start, a pair up to 200 ms
constexpr size_t kMaxChunks = 16;      // per class of match counts
constexpr double kLeastRatio = 0.25;
constexpr double kClassWidth = 1.25;  // ratio of the largest to the smallest match count of a class

using Word = std::array<float, kDescriptorBytes>;

size_t nearest_word(const uint8_t* descriptor, const std::vector<Word>& words) {
  size_t best = 0;
  float best_distance = 1e30f;
  for (size_t w = 0; w < words.size(); ++w) {
    float distance = 0;
    for (size_t k = 0; k < kDescriptorBytes; ++k) {
      const float d = float(descriptor[k]) - words[w][k];
      distance += d * d;
    }
    if (distance < best_distance) best_distance = distance, best = w;
  }
  return best;
}

// Lloyd's algorithm; the sums run in sample order.
std::vector<Word> vocabulary(std::span<const PhotoFeatures> photos, uint64_t seed) {
  std::vector<const uint8_t*> samples;
  for (size_t p = 0; p < photos.size(); ++p) {
    Rng rng(seed, mix64(1, p));
    for (size_t i = 0; i < std::min(kSamplesPerPhoto, photos[p].count); ++i)
      samples.push_back(photos[p].descriptors.data() + kDescriptorBytes * rng.below(static_cast<uint32_t>(photos[p].count)));
  }
  std::vector<Word> words(std::min(kWords, samples.size()));
  Rng rng(seed, mix64(2, 0));
  for (Word& word : words) {
    const uint8_t* start = samples[rng.below(static_cast<uint32_t>(samples.size()))];
    std::copy_n(start, kDescriptorBytes, word.begin());
  }
  std::vector<size_t> nearest(samples.size());
  for (int round = 0; round < kLearningRounds; ++round) {
    parallel_for(samples.size(), 256, [&](size_t i) { nearest[i] = nearest_word(samples[i], words); });
    std::vector<Word> sums(words.size(), Word{});
    std::vector<size_t> counts(words.size(), 0);
    for (size_t i = 0; i < samples.size(); ++i) {
      ++counts[nearest[i]];
      for (size_t k = 0; k < kDescriptorBytes; ++k) sums[nearest[i]][k] += float(samples[i][k]);
    }
    for (size_t w = 0; w < words.size(); ++w)
      for (size_t k = 0; k < kDescriptorBytes && counts[w] > 0; ++k) words[w][k] = sums[w][k] / float(counts[w]);
  }
  return words;
}

// VLAD: sum of differences to the nearest word, per word; then signed square root and L2 normalisation.
std::vector<float> global_descriptor(const PhotoFeatures& photo, const std::vector<Word>& words) {
  std::vector<float> out(words.size() * kDescriptorBytes, 0.f);
  for (size_t i = 0; i < std::min(photo.count, kDescribedPerPhoto); ++i) {
    const uint8_t* d = photo.descriptors.data() + i * kDescriptorBytes;
    const size_t w = nearest_word(d, words);
    for (size_t k = 0; k < kDescriptorBytes; ++k) out[w * kDescriptorBytes + k] += float(d[k]) - words[w][k];
  }
  double norm = 0;
  for (float& v : out) {
    v = std::copysign(std::sqrt(std::abs(v)), v);
    norm += double(v) * v;
  }
  if (norm > 0)
    for (float& v : out) v = float(v / std::sqrt(norm));
  return out;
}

}  // namespace

std::vector<std::vector<uint32_t>> nearest_by_appearance(std::span<const PhotoFeatures> photos, const PairRules& rules) {
  std::vector<std::vector<uint32_t>> out(photos.size());
  const bool any = std::any_of(photos.begin(), photos.end(), [](const PhotoFeatures& p) { return p.count > 0; });
  if (!any) return out;
  const std::vector<Word> words = vocabulary(photos, rules.seed);
  std::vector<std::vector<float>> described(photos.size());
  parallel_for(photos.size(), 1, [&](size_t p) { described[p] = global_descriptor(photos[p], words); });
  parallel_for(photos.size(), 1, [&](size_t p) {
    std::vector<std::pair<float, uint32_t>> others;
    for (size_t q = 0; q < photos.size(); ++q) {
      if (q == p || rules.same_rig(p, q)) continue;
      float similarity = 0;
      for (size_t k = 0; k < described[p].size(); ++k) similarity += described[p][k] * described[q][k];
      others.push_back({-similarity, static_cast<uint32_t>(q)});
    }
    std::sort(others.begin(), others.end());
    for (size_t i = 0; i < std::min(others.size(), static_cast<size_t>(rules.retrieved)); ++i) out[p].push_back(others[i].second);
  });
  return out;
}

std::vector<PhotoPair> candidate_pairs(std::span<const PhotoFeatures> photos, const PairRules& rules) {
  const uint32_t n = static_cast<uint32_t>(photos.size());
  std::set<PhotoPair> pairs;
  const auto add = [&](uint32_t a, uint32_t b) {
    if (a != b && !rules.same_rig(a, b)) pairs.insert({std::min(a, b), std::max(a, b)});
  };
  if (n <= static_cast<uint32_t>(std::max(0, rules.exhaustive_limit))) {
    for (uint32_t a = 0; a < n; ++a)
      for (uint32_t b = a + 1; b < n; ++b) add(a, b);
  } else {
    const uint32_t window = static_cast<uint32_t>(std::max(1, rules.window));
    for (uint32_t a = 0; a < n; ++a) {
      uint32_t next = a + 1;
      while (next < n && rules.same_rig(a, next)) ++next;
      for (uint32_t step = 0; step < window && next + step < n; ++step) add(a, next + step);
      for (uint32_t step = 2 * window; a + step < n; step *= 2) add(a, a + step);
    }
    const auto nearest = nearest_by_appearance(photos, rules);
    for (uint32_t a = 0; a < n; ++a)
      for (uint32_t b : nearest[a]) add(a, b);
  }
  return {pairs.begin(), pairs.end()};
}

std::vector<VerifyChunk> verify_chunks(std::span<const size_t> matches, size_t min_inliers) {
  const double fewest = double(std::max<size_t>(min_inliers, 1));
  const auto class_of = [&](double n) { return n > fewest ? static_cast<int>(std::log(n / fewest) / std::log(kClassWidth)) : 0; };
  const int last = class_of(fewest / kLeastRatio);  // from here on COLMAP's default ratio is larger
  std::map<int, std::vector<size_t>> classes;
  for (size_t i = 0; i < matches.size(); ++i) classes[std::min(last, class_of(double(matches[i])))].push_back(i);
  std::vector<VerifyChunk> chunks;
  for (const auto& [kind, members] : classes) {
    const double ratio = kind == last ? kLeastRatio : std::max(kLeastRatio, std::pow(kClassWidth, -(kind + 1)));
    const size_t count = std::min(kMaxChunks, chunk_count(members.size(), kPairsPerChunk));
    // Interleaved, so that every chunk has a similar share of overlapping pairs.
    for (size_t c = 0; c < count; ++c) {
      VerifyChunk chunk{.pairs = {}, .inlier_ratio = ratio};
      for (size_t i = c; i < members.size(); i += count) chunk.pairs.push_back(members[i]);
      chunks.push_back(std::move(chunk));
    }
  }
  return chunks;
}

}  // namespace vitrine
