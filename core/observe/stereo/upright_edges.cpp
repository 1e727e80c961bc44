#include "core/observe/stereo/upright_edges.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/math/median.h"

namespace vitrine {

namespace {

constexpr size_t kLevels = 32, kMostCells = 480;
constexpr double kPostSeenBy = 0.5;            // minimum share of the photos that see a cell
constexpr size_t kFewestPostPhotos = 6;        // and minimum number
constexpr int kPost = 1, kSurroundings = 18;   // cells: radii of an edge, and of its surroundings
constexpr float kFurthest = 6, kNearest = -3;  // clamp in standard deviations: one level must not dominate
constexpr float kShows = 0.7f;                 // standard deviations from which an edge shows at a level
constexpr int kApart = 2;                      // cells: minimum distance between two edges

// Box mean with the given radius over the non-negative cells.
std::vector<float> means(const std::vector<float>& plane, size_t nx, size_t ny, int radius) {
  const size_t stride = nx + 1;
  std::vector<double> sum(stride * (ny + 1), 0.0), count(sum);
  for (size_t y = 0; y < ny; ++y)
    for (size_t x = 0; x < nx; ++x) {
      const float value = plane[y * nx + x];
      const size_t i = (y + 1) * stride + x + 1;
      sum[i] = (value >= 0 ? double(value) : 0) + sum[i - 1] + sum[i - stride] - sum[i - stride - 1];
      count[i] = (value >= 0 ? 1 : 0) + count[i - 1] + count[i - stride] - count[i - stride - 1];
    }
  std::vector<float> out(plane.size(), -1.f);
  const auto r = size_t(radius);
  for (size_t y = 0; y < ny; ++y)
    for (size_t x = 0; x < nx; ++x) {
      const size_t a = (y - std::min(y, r)) * stride, b = std::min(ny, y + r + 1) * stride, c = x - std::min(x, r),
                   d = std::min(nx, x + r + 1);
      const double n = count[b + d] - count[a + d] - count[b + c] + count[a + c];
      if (n > 0) out[y * nx + x] = float((sum[b + d] - sum[a + d] - sum[b + c] + sum[a + c]) / n);
    }
  return out;
}

}  // namespace

UprightEdges::UprightEdges(std::span<const EdgeField> fields, const Bounds3& about) : low_(about.low) {
  // A cell is the size of one pixel at the scene centre.
  const Vec3d centre = about.centre(), extent = about.high - about.low;
  std::vector<double> pixels;
  for (const EdgeField& f : fields) pixels.push_back(length(f.view().centre_in_world() - centre) / f.view().intrinsics.fx);
  cell_ = std::max(upper_median(pixels), std::max(extent.x, extent.y) / double(kMostCells));
  nx_ = size_t(extent.x / cell_) + 1;
  ny_ = size_t(extent.y / cell_) + 1;
  levels_ = kLevels;
  step_ = extent.z / double(levels_ - 1);
  votes_.assign(nx_ * ny_ * levels_, -1.f);
  vote(fields);
  stand_out();
}

void UprightEdges::vote(std::span<const EdgeField> fields) {
  const size_t fewest = std::max(kFewestPostPhotos, size_t(std::ceil(kPostSeenBy * double(fields.size()))));
  parallel_for(ny_ * levels_, 8, [&](size_t row) {
    if (interrupt_signal() != 0) return;
    const double y = low_.y + cell_ * double(row % ny_), z = height(double(row / ny_));
    for (size_t x = 0; x < nx_; ++x) {
      float sum = 0;
      size_t seen = 0;
      for (const EdgeField& field : fields)
        if (const float edge = field.along({low_.x + cell_ * double(x), y, z}, {0, 0, 1}); edge >= 0) sum += edge, ++seen;
      if (seen >= fewest) votes_[row * nx_ + x] = sum / float(seen);
    }
  });
  throw_if_interrupted();
}

void UprightEdges::stand_out() {
  parallel_for(levels_, 1, [&](size_t level) {
    const auto begin = votes_.begin() + std::ptrdiff_t(index(0, 0, level));
    std::vector<float> plane(begin, begin + std::ptrdiff_t(nx_ * ny_));
    const std::vector<float> near = means(plane, nx_, ny_, kPost), around = means(plane, nx_, ny_, kSurroundings);
    std::vector<float> out(plane.size(), 0.f), sizes;
    for (size_t i = 0; i < plane.size(); ++i) {
      if (plane[i] < 0) continue;
      out[i] = 0.5f * (plane[i] + near[i]) - around[i];
      sizes.push_back(std::abs(out[i]));
    }
    const double sigma = sizes.empty() ? 0 : kSigmaPerDeviation * double(upper_median(sizes));
    for (size_t i = 0; i < out.size(); ++i)
      *(begin + std::ptrdiff_t(i)) =
          plane[i] < 0 || !(sigma > 0) ? 0.f : std::clamp(float(double(out[i]) / sigma), kNearest, kFurthest);
  });
}

std::vector<UprightEdge> UprightEdges::strongest(size_t most) const {
  // The run of levels with the largest sum.
  std::vector<float> strength(nx_ * ny_, 0.f);
  parallel_for(ny_, 8, [&](size_t y) {
    for (size_t x = 0; x < nx_; ++x) {
      float run = 0;
      for (size_t level = 0; level < levels_; ++level) {
        run = std::max(run, 0.f) + votes_[index(x, y, level)] - kShows;
        strength[y * nx_ + x] = std::max(strength[y * nx_ + x], run);
      }
    }
  });
  std::vector<UprightEdge> edges;
  for (size_t y = 0; y < ny_; ++y)
    for (size_t x = 0; x < nx_; ++x) {
      const float s = strength[y * nx_ + x];
      bool highest = s > 0;
      for (int dy = -kApart; highest && dy <= kApart; ++dy)
        for (int dx = -kApart; dx <= kApart; ++dx) {
          const auto u = std::ptrdiff_t(x) + dx, v = std::ptrdiff_t(y) + dy;
          if (u < 0 || v < 0 || u >= std::ptrdiff_t(nx_) || v >= std::ptrdiff_t(ny_)) continue;
          const float other = strength[size_t(v) * nx_ + size_t(u)];
          if (other > s || (other == s && (dy < 0 || (dy == 0 && dx < 0)))) highest = false;
        }
      if (highest) edges.push_back({low_.x + cell_ * double(x), low_.y + cell_ * double(y), double(s)});
    }
  std::ranges::stable_sort(edges, std::greater<>(), &UprightEdge::strength);
  if (edges.size() > most) edges.resize(most);
  return edges;
}

UprightEdges::Run UprightEdges::together(std::span<const UprightEdge> edges) const {
  std::vector<size_t> places;
  for (const UprightEdge& e : edges)
    places.push_back(index(std::min(size_t(std::lround((e.x - low_.x) / cell_)), nx_ - 1),
                           std::min(size_t(std::lround((e.y - low_.y) / cell_)), ny_ - 1), 0));
  float best = 0, run = 0;
  size_t begin = 0, first = 0, last = 0;
  for (size_t level = 0; level < levels_; ++level) {
    float sum = 0;
    for (size_t place : places) sum += votes_[place + index(0, 0, level)] / float(places.size());
    if (run <= 0) begin = level, run = 0;
    run += sum - kShows;
    if (run > best) best = run, first = begin, last = level;
  }
  float weakest = best > 0 ? 1e30f : 0.f;
  for (size_t place : places) {
    float sum = 0;
    for (size_t level = first; level <= last; ++level) sum += votes_[place + index(0, 0, level)] - kShows;
    weakest = std::min(weakest, sum);
  }
  return {height(double(first)), height(double(last)), double(best), double(weakest)};
}

}  // namespace vitrine
