#include "sample_data/generate/revolve.h"

#include <algorithm>
#include <cmath>

#include "sample_data/generate/texture.h"

namespace vitrine::generate {
namespace {

constexpr float kCreaseCosine = 0.82f;

struct Ring {
  float radius = 0, height = 0;
  Vec2f normal;  // (radial, up)
};
struct RingPair {
  size_t low = 0, high = 0;
};

Vec2f unit(const Vec2f& v) { return (1.0f / std::max(std::hypot(v.x, v.y), 1e-9f)) * v; }

// The rings and, for each piece of the profile, its two: neighbours share one unless a crease lies between them.
std::vector<RingPair> ring_pairs(std::span<const Vec2f> profile, std::vector<Ring>& rings) {
  std::vector<Vec2f> normals;  // of the pieces
  for (size_t i = 0; i + 1 < profile.size(); ++i) {
    const Vec2f d = unit(profile[i + 1] - profile[i]);
    normals.push_back({d.y, -d.x});
  }
  const auto crease = [&](size_t i) {
    return i == 0 || i == normals.size() || normals[i - 1].x * normals[i].x + normals[i - 1].y * normals[i].y < kCreaseCosine;
  };
  std::vector<RingPair> pairs;
  for (size_t i = 0; i < normals.size(); ++i) {
    const Vec2f &a = profile[i], &b = profile[i + 1];
    if (crease(i)) rings.push_back({a.x, a.y, normals[i]});
    rings.push_back({b.x, b.y, crease(i + 1) ? normals[i] : unit(normals[i] + normals[i + 1])});
    pairs.push_back({rings.size() - 2, rings.size() - 1});
  }
  return pairs;
}

}  // namespace

Profile smooth_profile(std::span<const Vec2f> knots, int steps) {
  const auto knot = [&](int i) { return knots[static_cast<size_t>(std::clamp(i, 0, static_cast<int>(knots.size()) - 1))]; };
  Profile profile{knots.front()};
  for (int i = 0; i + 1 < static_cast<int>(knots.size()); ++i)
    for (int s = 1; s <= steps; ++s) {
      const float t = static_cast<float>(s) / static_cast<float>(steps);
      const Vec2f a = knot(i - 1), b = knot(i), c = knot(i + 1), d = knot(i + 2);
      const Vec2f p = b + 0.5f * t * (c - a + t * (2.0f * a - 5.0f * b + 4.0f * c - d + t * (3.0f * b - 3.0f * c + d - a)));
      profile.push_back({std::max(p.x, 0.0f), p.y});
    }
  return profile;
}

Shape revolved(std::span<const Vec2f> profile, int around) {
  std::vector<Ring> rings;
  const std::vector<RingPair> pairs = ring_pairs(profile, rings);
  Shape shape;
  for (const Ring& ring : rings)
    for (int i = 0; i < around; ++i) {
      const float phi = 2.0f * kPi * static_cast<float>(i) / static_cast<float>(around);
      const Vec3f out{std::cos(phi), std::sin(phi), 0};
      shape.mesh.positions.push_back(ring.radius * out + Vec3f{0, 0, ring.height});
      shape.mesh.normals.push_back(normalized(ring.normal.x * out + Vec3f{0, 0, ring.normal.y}));
    }
  shape.uv.resize(shape.mesh.positions.size());
  const uint32_t n = static_cast<uint32_t>(around);
  for (const RingPair& pair : pairs)
    for (uint32_t i = 0; i < n; ++i) {
      const uint32_t low = static_cast<uint32_t>(pair.low) * n, high = static_cast<uint32_t>(pair.high) * n, next = (i + 1) % n;
      if (rings[pair.low].radius > 0) shape.mesh.faces.push_back({low + i, low + next, high + next});
      if (rings[pair.high].radius > 0) shape.mesh.faces.push_back({low + i, high + next, high + i});
    }
  return shape;
}

}  // namespace vitrine::generate
