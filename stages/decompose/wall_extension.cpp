#include "stages/decompose/wall_extension.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <vector>

#include "core/foundation/math/median.h"
#include "core/foundation/math/kd_tree.h"
#include "core/scene/surfels/activation.h"
#include "core/render/trace/tracer.h"
#include "stages/decompose/light_solver.h"

namespace vitrine {

namespace {

constexpr double kClosed = 0.75;   // share of azimuths with a wall top and no sky above: a closed room
constexpr size_t kEdgeTexels = 5;  // at the top of a wall; their median gives its distance

// Highest wall texel of a column with only unseen directions above it.
struct Top {
  size_t row = 0, texel = 0;
  float across = 0;  // horizontal distance of the wall; 0: no such wall
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

constexpr size_t kSkyBands = 32, kSkyAzimuths = 128;
constexpr size_t kLow = kSkyBands / 4, kHigh = 3 * kSkyBands / 4;  // walls are below, sky is above
constexpr float kPolished = 0.5f, kNoGlass = 0.3f;                 // specular weight, transmission
constexpr size_t kFewestPolished = 100;
constexpr float kSpotReach = 2;        // times the spread of the specular points: nearer surfels are those points themselves
constexpr double kBrighterSky = 2;     // times the walls
constexpr double kLeastCovered = 0.5;  // surfel coverage of a band: less was never reflected

struct PolishedSpot {
  Vec3f centre{};
  float radius = 0;
};

std::optional<PolishedSpot> polished_spot(std::span<const LitPoint> points) {
  Vec3d sum{};
  double count = 0, squares = 0;
  const auto each = [&](const auto& f) {
    for (const LitPoint& p : points)
      if (p.specular_weight > kPolished && p.transmission < kNoGlass) f(cast<double>(p.position));
  };
  each([&](const Vec3d& p) { sum += p, count += 1; });
  if (count < double(kFewestPolished)) return {};
  const Vec3d centre = (1 / count) * sum;
  each([&](const Vec3d& p) { squares += squared_length(p - centre); });
  return PolishedSpot{cast<float>(centre), kSpotReach * float(std::sqrt(squares / count))};
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
  // Mean light of each band over the directions above walls: single cells of a non-negative solution can be dark by chance.
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

TriMesh painted_shell(const ExtendedWalls& walls, const SplatLayer& layer, std::span<const Vec3f> irradiance, float reach) {
  TriMesh shell = walls.around.shell();
  // The shell's vertices have the order of the wall texels. An extended wall takes the position of its source texel.
  std::vector<Vec3f> shown;
  for (size_t t = 0; t < walls.source.size(); ++t)
    if (walls.around.wall[t]) {
      const size_t from = walls.source[t];
      shown.push_back(walls.around.centre + walls.around.distance[from] * walls.around.direction(from));
    }
  std::vector<Vec3f> positions;
  std::vector<uint32_t> index;
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* p = layer.at(Attribute::Mean, i);
    if (sigmoid(*layer.at(Attribute::Opacity, i)) < 0.5f) continue;
    positions.push_back({p[0], p[1], p[2]});
    index.push_back(uint32_t(i));
  }
  const KdTreef tree(positions);
  std::vector<KdTreef::Near> near;
  constexpr float pi = std::numbers::pi_v<float>;
  for (size_t v = 0; v < shell.positions.size(); ++v) {
    tree.nearest(shown[v], 6, reach, near);
    Vec3f sum{};
    for (const KdTreef::Near& n : near) sum += irradiance[index[n.index]];
    for (size_t c = 0; c < 3; ++c) {
      const float e = near.empty() ? pi : sum[c] / float(near.size());
      shell.colors[v][c] = std::clamp(pi * shell.colors[v][c] / std::max(1e-4f, e), 0.f, kMaxAlbedo);
    }
  }
  return shell;
}

std::optional<float> mirrored_horizon(const SplatLayer& reflection, std::span<const LitPoint> points) {
  const std::optional<PolishedSpot> spot = polished_spot(points);
  if (!spot || reflection.size() == 0) return {};
  const auto sine = [](size_t band) { return (float(band) + 0.5f) / float(kSkyBands); };
  std::vector<Vec3f> origins(kSkyBands * kSkyAzimuths, spot->centre), directions;
  for (size_t band = 0; band < kSkyBands; ++band)
    for (size_t a = 0; a < kSkyAzimuths; ++a) {
      const float across = std::sqrt(1 - sine(band) * sine(band));
      const float azimuth = 2 * std::numbers::pi_v<float> * (float(a) + 0.5f) / float(kSkyAzimuths);
      directions.push_back({across * std::cos(azimuth), across * std::sin(azimuth), sine(band)});
    }
  const std::unique_ptr<Tracer> tracer = make_tracer();
  tracer->build(reflection);
  const std::vector<float> near(origins.size(), spot->radius);
  RayValues seen;
  tracer->forward({.origins = origins, .directions = directions, .near = near}, {.sh_degree = reflection.sh_degree()}, seen,
                  nullptr);
  std::array<double, kSkyBands> light{};
  for (size_t band = 0; band < kSkyBands; ++band) {
    std::vector<double> of_band;
    double covered = 0;
    for (size_t i = band * kSkyAzimuths; i < (band + 1) * kSkyAzimuths; ++i) {
      of_band.push_back(double(luminance(seen.color[i])));
      covered += 1 - double(seen.transmittance[i]);
    }
    if (covered < kLeastCovered * double(kSkyAzimuths)) return {};
    light[band] = upper_median(of_band);
  }
  std::vector<double> low(light.begin(), light.begin() + kLow), high(light.begin() + kHigh, light.end());
  const double walls = upper_median(low), sky = upper_median(high), edge = 0.5 * (walls + sky);
  if (!(sky > kBrighterSky * walls)) return {};
  // Searches from above: a bright picture on a wall is no sky.
  size_t band = kHigh;
  while (band > 0 && light[band - 1] > edge) --band;
  return band == 0 ? 0.f : float(band) / float(kSkyBands);
}

}  // namespace vitrine
