#include "stages/decompose/lit_points.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/math/kd_tree.h"

namespace vitrine {

namespace {

constexpr int kRounds = 12;              // of k-means
constexpr size_t kNear = 12, kFar = 24;  // partners of a point
constexpr float kFarWeight = 0.5f;
constexpr float kChromaSigma = 0.03f;  // in r and g of r + g + b = 1: much larger differences mean different paint

Vec2f chromaticity(const Vec3f& c) {
  const float sum = std::max(1e-6f, c.x + c.y + c.z);
  return {c.x / sum, c.y / sum};
}
float squared_distance(const Vec2f& a, const Vec2f& b) {
  const Vec2f d = a - b;
  return d.x * d.x + d.y * d.y;
}

// Members of each cluster, and the cluster of each point.
struct Clusters {
  std::vector<uint32_t> of;
  std::vector<std::vector<uint32_t>> members;
};

Clusters k_means(std::span<const Vec2f> chroma, int count, uint64_t seed) {
  const size_t k = std::min(size_t(count), chroma.size());
  std::vector<Vec2f> centres;
  // k-means++: the first centre at random, further ones far from the existing ones.
  Rng rng(seed, 0x6b6d65616e73);
  centres.push_back(chroma[rng.below(uint32_t(chroma.size()))]);
  std::vector<float> distance(chroma.size(), 1e30f);
  while (centres.size() < k) {
    double total = 0;
    for (size_t i = 0; i < chroma.size(); ++i) {
      distance[i] = std::min(distance[i], squared_distance(chroma[i], centres.back()));
      total += distance[i];
    }
    double at = rng.uniform_double() * total;
    size_t chosen = chroma.size() - 1;
    for (size_t i = 0; i < chroma.size(); ++i)
      if ((at -= distance[i]) <= 0) {
        chosen = i;
        break;
      }
    centres.push_back(chroma[chosen]);
  }
  Clusters out;
  out.of.assign(chroma.size(), 0);
  for (int round = 0; round < kRounds; ++round) {
    std::vector<Vec2<double>> sum(k);
    std::vector<double> members(k, 0);
    for (size_t i = 0; i < chroma.size(); ++i) {
      size_t best = 0;
      for (size_t c = 1; c < k; ++c)
        if (squared_distance(chroma[i], centres[c]) < squared_distance(chroma[i], centres[best])) best = c;
      out.of[i] = uint32_t(best);
      sum[best] = sum[best] + Vec2<double>{chroma[i].x, chroma[i].y};
      members[best] += 1;
    }
    for (size_t c = 0; c < k; ++c)
      if (members[c] > 0) centres[c] = {float(sum[c].x / members[c]), float(sum[c].y / members[c])};
  }
  out.members.resize(k);
  for (size_t i = 0; i < chroma.size(); ++i) out.members[out.of[i]].push_back(uint32_t(i));
  return out;
}

}  // namespace

Affinity affinity(std::span<const Vec3f> positions, std::span<const Vec3f> radiance, const AffinityDesc& desc) {
  const size_t count = positions.size();
  std::vector<Vec2f> chroma(count);
  for (size_t i = 0; i < count; ++i) chroma[i] = chromaticity(radiance[i]);
  const Clusters clusters = k_means(chroma, desc.clusters, desc.seed);
  const KdTreef tree(positions);
  const float inverse = 1 / (2 * kChromaSigma * kChromaSigma);
  std::vector<std::vector<Affinity::Partner>> found(count);
  parallel_for(count, 64, [&](size_t i) {
    constexpr float kLeast = 0.05f;
    std::vector<KdTreef::Near> near;
    tree.nearest(positions[i], kNear + 1, desc.radius, near);
    const auto add = [&](uint32_t j, float factor) {
      const float w = factor * std::exp(-inverse * squared_distance(chroma[i], chroma[j]));
      if (j != i && w > kLeast) found[i].push_back({j, w});
    };
    for (const KdTreef::Near& n : near) add(n.index, 1.f);
    const std::vector<uint32_t>& same = clusters.members[clusters.of[i]];
    Rng rng(desc.seed, mix64(1, i));
    for (size_t n = 0; n < kFar; ++n) add(same[rng.below(uint32_t(same.size()))], kFarWeight);
  });
  Affinity out;
  out.begin.push_back(0);
  for (const auto& partners : found) {
    out.partners.insert(out.partners.end(), partners.begin(), partners.end());
    out.begin.push_back(uint32_t(out.partners.size()));
  }
  return out;
}

}  // namespace vitrine
