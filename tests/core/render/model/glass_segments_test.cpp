// Segments of rays through glass against spheres and panes, where they are known.
#include "core/render/model/glass_segments.h"

#include <gtest/gtest.h>

#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

constexpr float kVoxel = 0.02f;
constexpr int kWidth = 48, kHeight = 36;

View camera() {
  View v;
  v.intrinsics = {kWidth, kHeight, 60, 60, kWidth / 2.0, kHeight / 2.0};
  v.cam_from_world = test::looking_at({0, -2, 0}, {0, 0, 0});
  return v;
}

TriMesh together(TriMesh a, const TriMesh& b) {
  const auto first = uint32_t(a.positions.size());
  a.positions.insert(a.positions.end(), b.positions.begin(), b.positions.end());
  for (const auto& f : b.faces) a.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  return a;
}
TriMesh turned_inside_out(TriMesh m) {
  for (auto& f : m.faces) std::swap(f[1], f[2]);
  return m;
}

// Surfels of the glass: tau = 1 on spheres of these radii.
SplatLayer glass_layer(std::initializer_list<double> radii) {
  SplatLayer all(LayerKind::Diffuse, 0, 0);
  for (const double r : radii) {
    const SplatLayer one = test::sphere_layer(r);
    const size_t first = all.size();
    all.resize(first + one.size());
    for (Attribute a : {Attribute::Mean, Attribute::Opacity})
      std::ranges::copy(one.values(a), all.values(a).begin() + ptrdiff_t(first * one.width(a)));
  }
  std::ranges::fill(all.values(Attribute::Transmission), 6.f);
  return all;
}

// Depth of the sphere of radius r, 0 beside it; distances along the ray to both of its sides.
struct Chord {
  double front = 0, back = 0, per_z = 1;
};
Chord chord(const View& v, size_t pixel, double r) {
  const Vec3d ray = v.intrinsics.ray(double(pixel % kWidth) + 0.5, double(pixel / kWidth) + 0.5);
  const Vec3d d = transposed_times(v.cam_from_world.rotation, normalized(ray)), o = v.centre_in_world();
  const double b = dot(d, o), disc = b * b - dot(o, o) + r * r;
  if (disc < 0) return {};
  return {-b - std::sqrt(disc), -b + std::sqrt(disc), length(ray)};
}
std::vector<float> depth_of_sphere(const View& v, double r) {
  std::vector<float> z(kWidth * kHeight, 0.f);
  for (size_t i = 0; i < z.size(); ++i)
    if (const Chord c = chord(v, i, r); c.front > 0) z[i] = float(c.front / c.per_z);
  return z;
}
std::vector<float> mask_of(const std::vector<float>& z) {
  std::vector<float> m(z.size());
  for (size_t i = 0; i < m.size(); ++i) m[i] = z[i] > 0 ? 1.f : 0.f;
  return m;
}
size_t count(const GlassSegments& s, SegmentKind k) { return s.count[size_t(k)]; }

TEST(GlassSegments, AreTheChordsOfAGlassBallAndOfGlassInGlass) {
  const View v = camera();
  const std::vector<float> z = depth_of_sphere(v, 0.4), mask = mask_of(z);
  const TriMesh ball = test::sphere_mesh(0.4, {}, 96, 192);
  // A second shell of glass inside: its surfaces are passed.
  for (const bool nested : {false, true}) {
    const GlassMesh mesh(nested ? together(ball, test::sphere_mesh(0.2, {}, 48, 96)) : ball,
                         nested ? glass_layer({0.4, 0.2}) : glass_layer({0.4}), kVoxel);
    EXPECT_EQ(mesh.regions, nested ? 2u : 1u);
    const GlassSegments s = glass_segments(v, z, mask, mesh);
    EXPECT_TRUE(s.trusted);
    EXPECT_GT(count(s, SegmentKind::Closed), 0.9 * double(s.glass()));
    for (size_t i = 0; i < z.size(); ++i) {
      if (s.kind[i] != SegmentKind::Closed) continue;
      const Chord c = chord(v, i, 0.4);
      EXPECT_NEAR(s.front[i], c.front, 0.01) << i;
      EXPECT_NEAR(s.back[i], c.back, 0.01) << i;
    }
  }
}

TEST(GlassSegments, OpaqueThingsInsideAndBehindAreNoGlass) {
  const View v = camera();
  const std::vector<float> z = depth_of_sphere(v, 0.4), mask = mask_of(z);
  SplatLayer layer = glass_layer({0.4, 0.2});
  std::fill_n(layer.values(Attribute::Transmission).begin() + ptrdiff_t(layer.size() / 2), layer.size() / 2, -6.f);
  const GlassMesh mesh(together(test::sphere_mesh(0.4, {}, 96, 192), test::sphere_mesh(0.2, {}, 48, 96)), layer, kVoxel);
  EXPECT_EQ(mesh.regions, 1u);
  const GlassSegments s = glass_segments(v, z, mask, mesh);
  const size_t middle = kWidth * (kHeight / 2) + kWidth / 2;
  EXPECT_EQ(s.kind[middle], SegmentKind::Closed);
  EXPECT_NEAR(s.back[middle], 2.4, 0.01);
  // The same picture of an opaque ball: mesh and picture agree, and it is no glass.
  std::ranges::fill(layer.values(Attribute::Transmission), -6.f);
  const GlassSegments opaque = glass_segments(v, z, mask, GlassMesh(test::sphere_mesh(0.4, {}, 96, 192), layer, kVoxel));
  EXPECT_EQ(count(opaque, SegmentKind::NotGlass), opaque.glass());
  EXPECT_FALSE(is_split(opaque.kind[middle]));
}

TEST(GlassSegments, AnOpenPaneHasNoBackNorHasAThinOne) {
  const View v = camera();
  // Two sheets at y = -0.01 and, turned round, at y = +0.01; the first alone is a pane seen from one side only.
  const auto sheet = [](float y) {
    TriMesh m;
    constexpr uint32_t n = 24;
    for (uint32_t j = 0; j <= n; ++j)
      for (uint32_t i = 0; i <= n; ++i) m.positions.push_back({-0.3f + 0.025f * float(i), y, -0.3f + 0.025f * float(j)});
    for (uint32_t j = 0; j < n; ++j)
      for (uint32_t i = 0; i < n; ++i) {
        const uint32_t a = j * (n + 1) + i;
        m.faces.push_back({a, a + 1, a + n + 2});
        m.faces.push_back({a, a + n + 2, a + n + 1});
      }
    return m;
  };
  const TriMesh front = sheet(-0.01f);
  SplatLayer layer(LayerKind::Diffuse, 0, front.positions.size());
  for (size_t i = 0; i < layer.size(); ++i)
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::Mean, i)[c] = front.positions[i][c];
  std::ranges::fill(layer.values(Attribute::Transmission), 6.f);
  std::vector<float> z(kWidth * kHeight, 0.f);
  for (size_t i = 0; i < z.size(); ++i) {
    const Vec3d ray = v.intrinsics.ray(double(i % kWidth) + 0.5, double(i / kWidth) + 0.5);
    const double depth = 2 - 0.01;
    if (std::max(std::abs(ray.x), std::abs(ray.y)) * depth < 0.29) z[i] = float(depth);
  }
  for (const TriMesh& mesh : {front, together(front, turned_inside_out(sheet(0.01f)))}) {
    const GlassSegments s = glass_segments(v, z, mask_of(z), GlassMesh(mesh, layer, kVoxel));
    EXPECT_GT(s.glass(), 100u);
    EXPECT_EQ(count(s, SegmentKind::Open), s.glass());
    EXPECT_TRUE(s.trusted);
  }
}

TEST(GlassSegments, AMeshThatDisagreesIsNotUsed) {
  const View v = camera();
  const std::vector<float> z = depth_of_sphere(v, 0.4), mask = mask_of(z);
  const SplatLayer layer = glass_layer({0.4});
  const auto segments = [&](const TriMesh& mesh) { return glass_segments(v, z, mask, GlassMesh(mesh, layer, kVoxel)); };
  const TriMesh ball = test::sphere_mesh(0.4, {}, 48, 96);

  const GlassSegments small = segments(test::sphere_mesh(0.3, {}, 48, 96));
  EXPECT_FALSE(small.trusted);
  EXPECT_GT(count(small, SegmentKind::Apart) + count(small, SegmentKind::NoMesh), 0.9 * double(small.glass()));

  const GlassSegments inverted = segments(turned_inside_out(ball));
  EXPECT_EQ(count(inverted, SegmentKind::Closed) + count(inverted, SegmentKind::Open), 0u);
  EXPECT_FALSE(inverted.trusted);

  const GlassSegments nothing = segments(TriMesh{});
  EXPECT_EQ(count(nothing, SegmentKind::NoMesh), nothing.glass());
  EXPECT_FALSE(nothing.trusted);

  TriMesh half = ball;  // its left half is gone
  std::erase_if(half.faces, [&](const auto& f) { return half.positions[f[0]].x < 0; });
  const GlassSegments holed = segments(half);
  EXPECT_FALSE(holed.trusted);
  for (size_t i = 0; i < z.size(); ++i) {
    const Chord c = chord(v, i, 0.4);
    if (is_split(holed.kind[i])) {
      EXPECT_NEAR(holed.front[i], c.front, 0.07);
    }
  }
}

}  // namespace
}  // namespace vitrine
