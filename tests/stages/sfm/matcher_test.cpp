// The fused integer matcher against the textbook rule in doubles, for both kernels and for awkward sizes.
#include "stages/sfm/matcher.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>

#include "core/foundation/base/rng.h"
#include "core/foundation/base/timer.h"

namespace vitrine {
namespace {

// SIFT-like: non-negative, length about 512; photo b repeats part of photo a with noise.
std::vector<uint8_t> random_descriptors(size_t n, uint64_t seed) {
  std::vector<uint8_t> out(n * kDescriptorBytes);
  for (size_t i = 0; i < n; ++i) {
    Rng rng(seed, i);
    double v[kDescriptorBytes], norm = 0;
    for (double& x : v) {
      x = std::pow(double(rng.uniform()), 3.0);
      norm += x * x;
    }
    for (size_t k = 0; k < kDescriptorBytes; ++k)
      out[i * kDescriptorBytes + k] = static_cast<uint8_t>(std::min(255.0, std::round(512 * v[k] / std::sqrt(norm))));
  }
  return out;
}

std::vector<uint8_t> noisy_copy(const std::vector<uint8_t>& a, size_t n, uint64_t seed) {
  const size_t have = a.size() / kDescriptorBytes;
  std::vector<uint8_t> out = random_descriptors(n, seed + 1);
  for (size_t i = 0; i < n; i += 2) {  // every second one is a noisy copy of some descriptor of a
    Rng rng(seed, i);
    const size_t from = rng.below(static_cast<uint32_t>(have));
    const int amplitude = 1 + int(rng.below(60));  // from clear matches to failures of the ratio test
    for (size_t k = 0; k < kDescriptorBytes; ++k) {
      const int value = int(a[from * kDescriptorBytes + k]) + int(rng.below(uint32_t(2 * amplitude + 1))) - amplitude;
      out[i * kDescriptorBytes + k] = static_cast<uint8_t>(std::clamp(value, 0, 255));
    }
  }
  return out;
}

std::vector<int> best_neighbours(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  const size_t na = a.size() / kDescriptorBytes, nb = b.size() / kDescriptorBytes;
  std::vector<int> out(na, -1);
  for (size_t i = 0; i < na; ++i) {
    double best = 1e9, second = std::numbers::pi / 2;
    for (size_t j = 0; j < nb; ++j) {
      double product = 0;
      for (size_t k = 0; k < kDescriptorBytes; ++k)
        product += double(a[i * kDescriptorBytes + k]) * double(b[j * kDescriptorBytes + k]);
      const double angle = std::acos(std::min(1.0, product / (512.0 * 512.0)));
      if (j == 0) {
        best = angle, out[i] = 0;
      } else if (angle < best) {
        second = best, best = angle, out[i] = static_cast<int>(j);
      } else {
        second = j == 1 ? angle : std::min(second, angle);
      }
    }
    if (best > kMaxMatchAngle || best >= kMaxMatchRatio * second) out[i] = -1;
  }
  return out;
}

std::vector<Match> brute_force(const std::vector<uint8_t>& a, const std::vector<uint8_t>& b) {
  const std::vector<int> forth = best_neighbours(a, b), back = best_neighbours(b, a);
  std::vector<Match> out;
  for (size_t i = 0; i < forth.size(); ++i) {
    if (forth[i] < 0 || back[size_t(forth[i])] != int(i)) continue;
    out.push_back({uint32_t(i), uint32_t(forth[i])});
  }
  return out;
}

std::vector<MatchKernel> kernels() {
  std::vector<MatchKernel> out{MatchKernel::Avx2};
  if (available(MatchKernel::Avx512Vnni)) out.push_back(MatchKernel::Avx512Vnni);
  return out;
}

TEST(Matcher, FindsWhatTheRuleInDoublesFinds) {
  const std::pair<size_t, size_t> sizes[] = {{1, 1},   {1, 2},     {2, 1},     {5, 7},    {16, 64},
                                             {65, 63}, {130, 301}, {257, 260}, {600, 333}};
  size_t found = 0;
  for (const auto& [na, nb] : sizes) {
    const std::vector<uint8_t> a = random_descriptors(na, na * 1000 + nb), b = noisy_copy(a, nb, na + nb);
    const std::vector<Match> expected = brute_force(a, b);
    found += expected.size();
    for (const MatchKernel kernel : kernels())
      EXPECT_EQ(match(PackedDescriptors(a, kernel), PackedDescriptors(b, kernel)), expected) << na << " x " << nb;
  }
  EXPECT_GT(found, 200u);  // the sets do hold matches
}

TEST(Matcher, ExtremeBytesDoNotOverflow) {
  std::vector<uint8_t> a(3 * kDescriptorBytes, 0), b(2 * kDescriptorBytes, 0);
  std::fill_n(a.begin(), kDescriptorBytes, uint8_t(255));  // product with itself: 128 * 255^2, far over 512^2
  std::fill_n(b.begin(), kDescriptorBytes, uint8_t(255));
  a[kDescriptorBytes] = 255;
  for (const MatchKernel kernel : kernels())
    EXPECT_EQ(match(PackedDescriptors(a, kernel), PackedDescriptors(b, kernel)), brute_force(a, b));
}

TEST(Matcher, EqualDescriptorsFailTheRatioTest) {
  std::vector<uint8_t> a = random_descriptors(1, 3), b = a;
  b.insert(b.end(), a.begin(), a.end());
  for (const MatchKernel kernel : kernels()) {
    EXPECT_TRUE(match(PackedDescriptors(a, kernel), PackedDescriptors(b, kernel)).empty());
    EXPECT_TRUE(match(PackedDescriptors(a, kernel), PackedDescriptors(std::span<const uint8_t>(), kernel)).empty());
  }
}

TEST(Matcher, PrintsItsSpeedOnAPairOf4300Features) {
  const std::vector<uint8_t> a = random_descriptors(4300, 1), b = noisy_copy(a, 4300, 2);
  std::vector<Match> first;
  for (const MatchKernel kernel : kernels()) {
    const PackedDescriptors pa(a, kernel), pb(b, kernel);
    double best = 1e9;
    std::vector<Match> m;
    for (int i = 0; i < 3; ++i) {
      const double before = cpu_seconds();
      m = match(pa, pb);
      best = std::min(best, cpu_seconds() - before);
    }
    std::cout << (kernel == MatchKernel::Avx2 ? "AVX2 " : "AVX-512 VNNI ") << best * 1e3 << " ms of one core, " << m.size()
              << " matches\n";
    if (first.empty()) first = m;
    EXPECT_EQ(m, first);
    EXPECT_GT(m.size(), 500u);
  }
}

}  // namespace
}  // namespace vitrine
