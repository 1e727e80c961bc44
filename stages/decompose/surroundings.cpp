#include "stages/decompose/surroundings.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/scene/light/environment.h"
#include "core/foundation/math/quantile.h"
#include "core/render/trace/tracer.h"

namespace vitrine {

namespace {

// Distance at which a ray from inside a box leaves it.
float exit_of(const Bounds3& box, const Vec3f& origin, const Vec3f& direction) {
  double t = std::numeric_limits<double>::max();
  for (size_t c = 0; c < 3; ++c) {
    if (direction[c] == 0) continue;
    const double side = direction[c] > 0 ? box.high[c] : box.low[c];
    t = std::min(t, (side - origin[c]) / direction[c]);
  }
  return static_cast<float>(std::max(0.0, t));
}

}  // namespace

size_t Surroundings::texel_of(const Vec3f& d) const {
  const int width = 2 * height;
  const Vec2f uv = lat_long_coordinates(d);
  const int x = std::min(static_cast<int>(uv.x * float(width)), width - 1);
  const int y = std::min(static_cast<int>(uv.y * float(height)), height - 1);
  return size_t(y) * size_t(width) + size_t(x);
}

Vec3f Surroundings::direction(size_t texel) const {
  const size_t width = 2 * size_t(height);
  return lat_long_direction((float(texel % width) + 0.5f) / float(width), (float(texel / width) + 0.5f) / float(height));
}

double Surroundings::wall_share() const {
  double share = 0;
  for (size_t t = 0; t < wall.size(); ++t) {
    if (!wall[t]) continue;
    const double elevation = std::numbers::pi * (0.5 - (double(t / (2 * size_t(height))) + 0.5) / height);
    share += std::cos(elevation) * std::numbers::pi / (4.0 * height * height);
  }
  return share;
}

TriMesh Surroundings::shell() const {
  TriMesh mesh;
  constexpr uint32_t kNone = 0xffffffffu;
  std::vector<uint32_t> corner(distance.size(), kNone);
  for (size_t t = 0; t < distance.size(); ++t) {
    if (!wall[t]) continue;
    corner[t] = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.push_back(centre + distance[t] * direction(t));
    mesh.colors.push_back(radiance[t]);
  }
  const size_t width = 2 * size_t(height);
  for (size_t y = 0; y + 1 < size_t(height); ++y)
    for (size_t x = 0; x < width; ++x) {
      // Rows go down, columns clockwise as seen from above: from inside, a b are above d c.
      const uint32_t a = corner[y * width + x], b = corner[y * width + (x + 1) % width];
      const uint32_t d = corner[(y + 1) * width + x], c = corner[(y + 1) * width + (x + 1) % width];
      if (a != kNone && c != kNone && b != kNone) mesh.faces.push_back({a, c, b});
      if (a != kNone && d != kNone && c != kNone) mesh.faces.push_back({a, d, c});
    }
  return mesh;
}

float distance_to_sky(std::span<const Vec3f> triangulated, const Bounds3& inner) {
  constexpr double kPercentile = 0.995;
  constexpr float kBeyond = 1.25f;
  if (triangulated.empty()) return std::numeric_limits<float>::max();
  const Vec3f centre = cast<float>(inner.centre());
  std::vector<float> distance;
  for (const Vec3f& p : triangulated) distance.push_back(length(p - centre));
  return kBeyond * std::max(quantile_of(distance, kPercentile), float(0.5 * inner.diagonal()));
}

Surroundings surroundings(const SplatLayer& diffuse, const SurroundingsDesc& desc) {
  Surroundings out;
  out.centre = cast<float>(desc.inner.centre());
  out.height = desc.height;
  const size_t count = 2 * size_t(desc.height) * size_t(desc.height);
  std::vector<Vec3f> origins(count, out.centre), directions(count);
  std::vector<float> near(count);
  for (size_t t = 0; t < count; ++t) {
    directions[t] = out.direction(t);
    near[t] = exit_of(desc.inner, out.centre, directions[t]);
  }
  const std::unique_ptr<Tracer> tracer = make_tracer();
  tracer->build(diffuse);
  RayValues values;
  // Slightly less than the wall threshold, so that rounding loses no wall.
  tracer->forward({.origins = origins, .directions = directions, .near = near},
                  {.sh_degree = diffuse.sh_degree(), .first_hit_weight = 0.99f * desc.min_alpha}, values, nullptr);
  out.distance.assign(count, 0.f);
  out.radiance.assign(count, Vec3f{});
  out.wall.assign(count, false);
  for (size_t t = 0; t < count; ++t) {
    const float alpha = 1 - values.transmittance[t];
    if (!(alpha >= desc.min_alpha)) continue;
    out.distance[t] = values.first_hit[t];  // a mean would lie between a wall and the sky behind it
    out.radiance[t] = values.color[t] / alpha;
    out.wall[t] = out.distance[t] < desc.sky_distance;
  }
  return out;
}

}  // namespace vitrine
