#include "stages/decompose/wall_extension.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "core/math/median.h"
#include "stages/decompose/light_solver.h"

namespace vitrine {

namespace {

constexpr double kClosed = 0.75;   // share of the azimuths with an upper end of a wall and no sky over it: a closed room
constexpr size_t kEdgeTexels = 5;  // at the upper end of a wall, of which the median tells where it stands

// The highest wall texel of a column with nothing but unseen directions above it.
struct Top {
  size_t row = 0, texel = 0;
  float across = 0;  // horizontal distance of the wall; 0: there is no such wall
};

Top top_of(const Surroundings& around, size_t column) {
  const size_t rows = size_t(around.height), width = 2 * rows;
  size_t row = 0;
  while (row < rows / 2 && !around.seen(row * width + column)) ++row;
  if (row == rows / 2 || !around.wall[row * width + column]) return {};
  std::array<float, kEdgeTexels> across{};
  size_t count = 0;
  for (size_t y = row; y < rows && count < kEdgeTexels; ++y) {
    const size_t t = y * width + column;
    if (!around.wall[t]) break;
    const Vec3f d = around.direction(t);
    across[count++] = around.distance[t] * std::hypot(d.x, d.y);
  }
  return {row, row * width + column, upper_median_of(std::span(across).first(count))};
}

float wall_luminance(const Surroundings& around) {
  double sum = 0, weight = 0;
  for (size_t t = 0; t < around.wall.size(); ++t) {
    if (!around.wall[t]) continue;
    const Vec3f d = around.direction(t);
    const double w = std::hypot(d.x, d.y);
    sum += w * double(luminance(around.radiance[t])), weight += w;
  }
  return weight > 0 ? float(sum / weight) : 0.f;
}

}  // namespace

ExtendedWalls extended_walls(const Surroundings& around, const LightGrid& grid, std::span<const Vec3f> light,
                             const std::vector<bool>& free, float horizon) {
  ExtendedWalls out{around, std::vector<size_t>(around.distance.size()), 0};
  std::iota(out.source.begin(), out.source.end(), size_t(0));
  const size_t width = 2 * size_t(around.height);
  std::vector<Top> tops(width);
  for (size_t x = 0; x < width; ++x) tops[x] = top_of(around, x);
  const auto walls = std::ranges::count_if(tops, [](const Top& top) { return top.across > 0; });
  if (double(walls) < kClosed * double(width)) return out;
  // Mean light of each band over the directions above walls: single cells of a non-negative solution are dark by chance.
  std::vector<double> sum(grid.bands, 0), count(grid.bands, 0);
  for (size_t x = 0; x < width; ++x)
    for (size_t y = 0; tops[x].across > 0 && y < tops[x].row; ++y)
      if (const size_t cell = grid.cell_of(around.direction(y * width + x)); free[cell]) {
        sum[cell / grid.azimuths()] += double(luminance(light[cell]));
        count[cell / grid.azimuths()] += 1;
      }
  const double bright = double(wall_luminance(around));
  for (size_t band = grid.bands; band-- > 0;) {
    if (count[band] == 0) continue;
    if (sum[band] > bright * count[band]) break;
    out.sine = 1 - 2 * float(band) / float(grid.bands);
  }
  out.sine = std::min(out.sine, horizon);
  for (size_t x = 0; x < width; ++x)
    for (size_t y = 0; tops[x].across > 0 && y < tops[x].row; ++y) {
      const size_t t = y * width + x;
      const Vec3f d = around.direction(t);
      if (d.z > out.sine) continue;
      out.around.distance[t] = tops[x].across / std::hypot(d.x, d.y);
      out.around.radiance[t] = around.radiance[tops[x].texel];
      out.around.wall[t] = true;
      out.source[t] = tops[x].texel;
    }
  return out;
}

}  // namespace vitrine
