#include "core/observe/stereo/silhouette.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/foundation/math/connected_components.h"

namespace vitrine {

namespace {

constexpr double kLeastOfHull = 0.75;  // minimum share of the convex hull that the mask covers; occluders hide the rest
constexpr double kLeastOfQuad = 0.93;  // minimum share of the quadrilateral that the hull covers: a disc has .79, a hexagon .75

double turn(const Vec2d& a, const Vec2d& b) { return a.x * b.y - a.y * b.x; }

double area_of(std::span<const Vec2d> polygon) {
  double sum = 0;
  for (size_t i = 0; i < polygon.size(); ++i) sum += turn(polygon[i], polygon[(i + 1) % polygon.size()]);
  return 0.5 * sum;
}

// Simplifies a convex polygon to four corners: repeatedly removes the side whose removal adds the least area, and extends its
// neighbours until they meet.
std::optional<std::array<Vec2d, 4>> four_corners(std::vector<Vec2d> polygon) {
  while (polygon.size() > 4) {
    const size_t n = polygon.size();
    double least = 1e300;
    size_t taken = n;
    Vec2d corner{};
    for (size_t i = 0; i < n; ++i) {
      const Vec2d a = polygon[(i + n - 1) % n], b = polygon[i], c = polygon[(i + 1) % n], d = polygon[(i + 2) % n];
      const double between = turn(b - a, d - c);
      if (!(between > 1e-9)) continue;
      const Vec2d meeting = b + turn(c - b, d - c) / between * (b - a);
      const double added = 0.5 * turn(meeting - b, c - meeting);
      if (added >= 0 && added < least) least = added, taken = i, corner = meeting;
    }
    if (taken == n) return std::nullopt;
    polygon[taken] = corner;
    polygon.erase(polygon.begin() + static_cast<ptrdiff_t>((taken + 1) % n));
  }
  if (polygon.size() < 4) return std::nullopt;
  return std::array<Vec2d, 4>{polygon[0], polygon[1], polygon[2], polygon[3]};
}

}  // namespace

MaskPieces mask_pieces(const Silhouette& mask) {
  const auto width = size_t(mask.value.width()), count = width * size_t(mask.value.height());
  const auto& value = mask.value.data();
  const ConnectedComponents parts = connected_components(
      count, [&](size_t i) { return value[i] >= 0.5f; },
      [&](size_t i, const auto& visit) {
        if (i % width > 0) visit(i - 1);
        if (i % width + 1 < width) visit(i + 1);
        if (i >= width) visit(i - width);
        if (i + width < count) visit(i + width);
      });
  return {parts.label, parts.members};
}

std::vector<Vec2d> convex_hull(std::vector<Vec2d> points) {
  std::sort(points.begin(), points.end(), [](const Vec2d& a, const Vec2d& b) { return a.x < b.x || (a.x == b.x && a.y < b.y); });
  if (points.size() < 3) return points;
  std::vector<Vec2d> hull;
  const auto add = [&](const Vec2d& p, size_t first) {
    while (hull.size() >= first + 2 && turn(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) hull.pop_back();
    hull.push_back(p);
  };
  for (const Vec2d& p : points) add(p, 0);
  const size_t lower = hull.size() - 1;
  for (size_t i = points.size() - 1; i-- > 0;) add(points[i], lower);
  hull.pop_back();
  return hull;
}

std::vector<Quadrilateral> quadrilaterals(const Silhouette& mask, double least_share) {
  const int width = mask.value.width(), height = mask.value.height();
  std::vector<Quadrilateral> out;
  for (const std::vector<size_t>& pixels : mask_pieces(mask).pixels) {
    if (double(pixels.size()) < least_share * width * height) continue;
    std::vector<Vec2d> ends;  // corners of the first and last pixel of every row
    std::vector<std::array<int, 2>> rows(size_t(height), {width, -1});
    for (const size_t i : pixels) {
      auto& row = rows[i / size_t(width)];
      const int x = int(i % size_t(width));
      row = {std::min(row[0], x), std::max(row[1], x)};
    }
    bool at_border = rows.front()[1] >= 0 || rows.back()[1] >= 0;
    for (size_t y = 0; y < rows.size(); ++y) {
      if (rows[y][1] < 0) continue;
      at_border = at_border || rows[y][0] == 0 || rows[y][1] + 1 == width;
      for (const double x : {double(rows[y][0]), double(rows[y][1] + 1)})
        for (const double edge : {double(y), double(y + 1)}) ends.push_back({x, edge});
    }
    if (at_border) continue;
    const std::vector<Vec2d> hull = convex_hull(std::move(ends));
    const double hull_area = area_of(hull);
    if (double(pixels.size()) < kLeastOfHull * hull_area) continue;
    const auto corners = four_corners(hull);
    if (!corners) continue;
    const double area = area_of(*corners);
    if (hull_area >= kLeastOfQuad * area) out.push_back({*corners, area});
  }
  return out;
}

}  // namespace vitrine
