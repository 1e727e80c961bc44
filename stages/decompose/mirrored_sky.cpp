#include "stages/decompose/mirrored_sky.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "core/math/median.h"
#include "core/trace/tracer.h"
#include "stages/decompose/light_solver.h"

namespace vitrine {

namespace {

constexpr size_t kSkyBands = 32, kSkyAzimuths = 128;
constexpr size_t kLow = kSkyBands / 4, kHigh = 3 * kSkyBands / 4;  // walls are below, sky is above
constexpr float kPolished = 0.5f, kNoGlass = 0.3f;                 // specular weight, transmission
constexpr size_t kFewestPolished = 100;
constexpr float kSpotReach = 2;        // of the spread of the polished points: what is nearer are they themselves
constexpr double kBrighterSky = 2;     // times the walls
constexpr double kLeastCovered = 0.5;  // of a band's light by surfels: less was never mirrored

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
  // From above: a bright picture on a wall is no sky.
  size_t band = kHigh;
  while (band > 0 && light[band - 1] > edge) --band;
  return band == 0 ? 0.f : float(band) / float(kSkyBands);
}

}  // namespace vitrine
