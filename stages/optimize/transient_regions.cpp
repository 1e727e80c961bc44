#include <algorithm>
#include <cmath>

#include "stages/optimize/transients.h"

namespace vitrine {

namespace {

using Pixels = std::vector<uint8_t>;  // [h,w] 0 or 1

constexpr float kWeak = 0.035f, kStrong = 0.09f;        // residual of hysteresis
constexpr float kWeakRatio = 1.4f, kStrongRatio = 2.f;  // to that of the other photos
constexpr float kPhotoNoise = 0.01f;                    // added to the latter
constexpr double kStrongShare = 0.25;                   // of the pixels of a region
// Lengths, as fractions of the longest side.
constexpr double kSolidRegion = 1.0 / 80, kGrown = 1.0 / 60, kClosed = 1.0 / 40, kRegionMargin = 1.0 / 80;
// Area of a region, as a fraction of the picture. Static scenes have regions up to 0.0053: highlights, rims, corners of photos.
constexpr double kSmallest = 0.001, kAlone = 0.007;
constexpr double kTogether =
    1.0 / 8;  // largest distance of a small region from one that is large enough alone, of the longest side

struct Grid {
  int width, height;
  size_t size() const { return size_t(width) * size_t(height); }
  bool inside(int x, int y) const { return x >= 0 && y >= 0 && x < width && y < height; }
  size_t index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
};

// Dilation of the pixels equal to `value` by a disc; pixels outside the picture count as not equal.
Pixels spread(const Grid& grid, const Pixels& pixels, int radius, uint8_t value) {
  Pixels result = pixels;
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      if (pixels[grid.index(x, y)] != value) continue;
      for (int dy = -radius; dy <= radius; ++dy)
        for (int dx = -radius; dx <= radius; ++dx)
          if (dx * dx + dy * dy <= radius * radius + radius / 2 && grid.inside(x + dx, y + dy))
            result[grid.index(x + dx, y + dy)] = value;
    }
  return result;
}

Pixels closed(const Grid& grid, const Pixels& pixels, int radius) {
  return spread(grid, spread(grid, pixels, radius, 1), radius, 0);
}
Pixels opened(const Grid& grid, const Pixels& pixels, int radius) {
  return spread(grid, spread(grid, pixels, radius, 0), radius, 1);
}

// Pixels with `value` that are connected to (x, y), which lose it in `pixels`.
std::vector<size_t> taken_component(const Grid& grid, Pixels& pixels, size_t start, uint8_t value) {
  std::vector<size_t> component{start};
  pixels[start] = !value;
  for (size_t next = 0; next < component.size(); ++next) {
    const int x = int(component[next] % size_t(grid.width)), y = int(component[next] / size_t(grid.width));
    for (const auto& [dx, dy] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
      if (!grid.inside(x + dx, y + dy) || pixels[grid.index(x + dx, y + dy)] != value) continue;
      pixels[grid.index(x + dx, y + dy)] = !value;
      component.push_back(grid.index(x + dx, y + dy));
    }
  }
  return component;
}

Pixels without_holes(const Grid& grid, const Pixels& pixels) {
  Pixels empty = pixels, result(pixels.size(), 1);
  for (int y = 0; y < grid.height; ++y)
    for (int x = 0; x < grid.width; ++x) {
      const bool border = x == 0 || y == 0 || x + 1 == grid.width || y + 1 == grid.height;
      if (!border || empty[grid.index(x, y)]) continue;
      for (const size_t i : taken_component(grid, empty, grid.index(x, y), 0)) result[i] = 0;
    }
  return result;
}

}  // namespace

std::vector<uint8_t> transient_regions(const TransientEvidence& evidence, std::span<const uint8_t> excluded, int width,
                                       int height) {
  const Grid grid{width, height};
  const auto pixels_of = [&](double part) { return std::max(1, int(std::lround(part * std::max(width, height)))); };
  Pixels weak(grid.size(), 0), strong(grid.size(), 0);
  for (size_t i = 0; i < grid.size(); ++i) {
    const float ratio = evidence.residual[i] / (evidence.elsewhere[i] + kPhotoNoise);
    weak[i] = evidence.residual[i] > kWeak && ratio > kWeakRatio;
    strong[i] = evidence.residual[i] > kStrong && ratio > kStrongRatio;
  }
  weak = closed(grid, weak, 1);
  const auto counts = [&](size_t i) { return excluded.empty() || !excluded[i]; };
  Pixels solid = opened(grid, weak, pixels_of(kSolidRegion)), large(grid.size(), 0), small(grid.size(), 0);
  bool any = false;
  for (size_t start = 0; start < grid.size(); ++start) {
    if (!solid[start]) continue;
    const std::vector<size_t> region = taken_component(grid, solid, start, 1);
    const auto area = double(std::ranges::count_if(region, counts));
    const auto sure = double(std::ranges::count_if(region, [&](size_t i) { return counts(i) && strong[i]; }));
    if (area < kSmallest * double(grid.size()) || sure < kStrongShare * area) continue;
    const bool alone = area >= kAlone * double(grid.size());
    for (const size_t i : region) (alone ? large : small)[i] = 1;
    any |= alone;
  }
  if (!any) return {};
  Pixels regions = large;
  const Pixels around_large = spread(grid, large, pixels_of(kTogether), 1);
  for (size_t i = 0; i < grid.size(); ++i) regions[i] |= small[i] & around_large[i];
  const Pixels near = spread(grid, regions, pixels_of(kGrown), 1);
  for (size_t i = 0; i < grid.size(); ++i) regions[i] |= near[i] & weak[i];
  regions = spread(grid, without_holes(grid, closed(grid, regions, pixels_of(kClosed))), pixels_of(kRegionMargin), 1);
  for (uint8_t& pixel : regions) pixel *= 255;
  return regions;
}

}  // namespace vitrine
