#include "core/math/point_grid.h"

#include <algorithm>
#include <cmath>

#include "core/base/rng.h"

namespace vitrine {

namespace {
constexpr float kFarthest = 1e9f;  // cells; indices of cells beyond are no integers of a float
}

PointGrid::PointGrid(std::span<const Vec3f> points, float cell) : points_(points), cell_(cell) {
  for (size_t i = 0; i < points.size(); ++i)
    cells_[key(coordinate(points[i].x), coordinate(points[i].y), coordinate(points[i].z))].push_back(static_cast<uint32_t>(i));
}

int64_t PointGrid::coordinate(float x) const { return static_cast<int64_t>(std::floor(x / cell_)); }

uint64_t PointGrid::key(int64_t x, int64_t y, int64_t z) {
  return mix64(mix64(static_cast<uint64_t>(x), static_cast<uint64_t>(y)), static_cast<uint64_t>(z));
}

void PointGrid::nearest(const Vec3f& p, size_t count, float radius, std::vector<Near>& out) const {
  out.clear();
  const int64_t cx = coordinate(p.x), cy = coordinate(p.y), cz = coordinate(p.z);
  const auto closer = [](const Near& a, const Near& b) {
    return a.squared_distance != b.squared_distance ? a.squared_distance < b.squared_distance : a.index < b.index;
  };
  const auto last = static_cast<int64_t>(std::ceil(radius / cell_));
  for (int64_t shell = 0; shell <= last; ++shell) {
    for (int64_t x = cx - shell; x <= cx + shell; ++x)
      for (int64_t y = cy - shell; y <= cy + shell; ++y) {
        const bool rim = std::abs(x - cx) == shell || std::abs(y - cy) == shell;
        for (int64_t z = cz - shell; z <= cz + shell; z += rim ? 1 : std::max<int64_t>(1, 2 * shell)) {
          const auto it = cells_.find(key(x, y, z));
          if (it == cells_.end()) continue;
          for (const uint32_t i : it->second)
            if (const float d = squared_length(points_[i] - p); d <= radius * radius) out.push_back({i, d});
        }
      }
    // What later shells hold is at least `shell` cells away.
    const float safe = static_cast<float>(shell) * cell_;
    const auto certain = std::ranges::count_if(out, [&](const Near& n) { return n.squared_distance <= safe * safe; });
    if (static_cast<size_t>(certain) >= count) break;
  }
  std::ranges::sort(out, closer);
  if (out.size() > count) out.resize(count);
}

bool PointGrid::any(const Vec3f& p, float radius) const {
  if (!(squared_length(p) < kFarthest * kFarthest * cell_ * cell_)) return false;
  const auto last = static_cast<int64_t>(std::ceil(radius / cell_));
  const int64_t cx = coordinate(p.x), cy = coordinate(p.y), cz = coordinate(p.z);
  for (int64_t x = cx - last; x <= cx + last; ++x)
    for (int64_t y = cy - last; y <= cy + last; ++y)
      for (int64_t z = cz - last; z <= cz + last; ++z)
        if (const auto it = cells_.find(key(x, y, z)); it != cells_.end())
          for (const uint32_t i : it->second)
            if (squared_length(points_[i] - p) <= radius * radius) return true;
  return false;
}

}  // namespace vitrine
