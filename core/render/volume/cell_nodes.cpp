#include "core/render/volume/cell_nodes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace vitrine {

namespace {

// Optical depth of each bin of [low, high].
std::vector<double> depth_of_bins(std::span<const TileProfile> profiles, double low, double high, size_t bins) {
  std::vector<double> depth(bins);
  const double bin = (high - low) / double(bins);
  for (const TileProfile& p : profiles) {
    const double half = std::max(p.half, 0.5 * bin), begin = (p.at - half - low) / bin, end = (p.at + half - low) / bin;
    const auto last = static_cast<size_t>(std::clamp(std::ceil(end), 0., double(bins)));
    for (auto i = static_cast<size_t>(std::clamp(begin, 0., double(bins - 1))); i < last; ++i)
      depth[i] += p.depth * std::max(0., std::min(double(i + 1), end) - std::max(double(i), begin)) / (end - begin);
  }
  return depth;
}

// Those that count: others, which may lie anywhere, would pull borders away. A profile without depth has no place, either.
std::vector<TileProfile> visible(std::span<const TileProfile> profiles) {
  constexpr double kLeastShare = 1e-5;
  double sum = 0;
  for (const TileProfile& p : profiles) sum += p.depth;
  std::vector<TileProfile> out;
  for (const TileProfile& p : profiles)
    if (p.depth > kLeastShare * sum) out.push_back(p);
  return out;
}

}  // namespace

std::vector<float> cell_nodes(std::span<const TileProfile> all, int cells) {
  constexpr size_t kBins = 128;
  constexpr double kEven = 0.15;  // share of borders that are spread evenly
  const std::vector<TileProfile> profiles = visible(all);
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const TileProfile& p : profiles) {
    low = std::min(low, p.at - p.half);
    high = std::max(high, p.at + p.half);
  }
  if (!(low < high)) low = -1, high = 1;  // nothing to see
  const std::vector<double> depth = depth_of_bins(profiles, low, high, kBins);
  std::vector<double> sum(kBins + 1);
  double before = 0;
  for (size_t i = 0; i < kBins; ++i) {
    sum[i + 1] = sum[i] + std::sqrt(std::exp(-0.5 * before) * -std::expm1(-depth[i]));
    before += depth[i];
  }
  const double total = sum.back();
  for (size_t i = 0; i <= kBins; ++i) {
    const double even = double(i) / double(kBins);
    sum[i] = total > 0 ? (1 - kEven) * sum[i] / total + kEven * even : even;
  }
  std::vector<float> nodes;
  size_t at = 0;
  for (int k = 1; k < cells; ++k) {
    const double wanted = double(k) / cells;
    while (at + 1 < kBins && sum[at + 1] < wanted) ++at;
    const double part = std::clamp((wanted - sum[at]) / (sum[at + 1] - sum[at]), 0., 1.);
    nodes.push_back(static_cast<float>(low + (high - low) * (double(at) + part) / double(kBins)));
  }
  return nodes;
}

}  // namespace vitrine
