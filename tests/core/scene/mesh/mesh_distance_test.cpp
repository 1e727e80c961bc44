#include "core/scene/mesh/mesh_distance.h"

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "tests/core/scene/mesh/shapes.h"

namespace vitrine {
namespace {

TEST(SampleSurface, IsUniformByAreaAndRepeatable) {
  TriMesh m = shapes::grid(1);  // area 1 at z = 0
  TriMesh big = shapes::grid(8, 5);
  for (Vec3f& p : big.positions) p = {3 * p.x, p.y, p.z};  // area 3 at z = 5
  shapes::append(m, big);
  const SurfaceSamples s = sample_surface(m, 4000, 1);
  ASSERT_EQ(s.positions.size(), 4000u);
  size_t high = 0, left = 0;
  for (size_t i = 0; i < s.positions.size(); ++i) {
    high += s.positions[i].z > 2;
    left += s.positions[i].z > 2 && s.positions[i].x < 1.5f;
    EXPECT_EQ(s.normals[i], (Vec3f{0, 0, 1}));
  }
  EXPECT_NEAR(double(high), 3000, 2);  // systematic along the area
  EXPECT_NEAR(double(left), 1500, 60);
  set_thread_limit(1);
  const SurfaceSamples one = sample_surface(m, 4000, 1);
  set_thread_limit(0);
  EXPECT_EQ(one.positions, s.positions);
  EXPECT_NE(sample_surface(m, 4000, 2).positions, s.positions);
  EXPECT_TRUE(sample_surface(TriMesh{}, 10, 1).positions.empty());
}

TEST(MeshDistance, MatchesTheAnalyticDistanceToACube) {
  const MeshDistance distance(shapes::cube());
  Rng rng(3);
  for (int i = 0; i < 2000; ++i) {
    const Vec3f p{4 * rng.uniform() - 1.5f, 4 * rng.uniform() - 1.5f, 4 * rng.uniform() - 1.5f};
    Vec3f outside{};
    float inside = 1e9f;
    for (size_t k = 0; k < 3; ++k) {
      outside[k] = std::max({-p[k], p[k] - 1, 0.f});
      inside = std::min({inside, p[k], 1 - p[k]});
    }
    const float expected = inside > 0 ? inside : length(outside);
    const ClosestPoint c = distance.closest(p);
    EXPECT_NEAR(c.distance, expected, 2e-6);
    EXPECT_NEAR(length(c.position - p), expected, 2e-6);
  }
}

TEST(MeshDistance, MatchesBruteForceWhenFacesAreDegenerateOrRepeated) {
  TriMesh m = shapes::sphere({0, 0, 0}, 1, 6, 7);
  m.faces.push_back({0, 0, 0});  // a point
  m.positions.push_back({3, 0, 0});
  m.faces.push_back({0, static_cast<uint32_t>(m.positions.size()) - 1, 0});  // a segment
  m.faces.push_back(m.faces[0]);
  std::vector<MeshDistance> single;
  for (const auto& f : m.faces) single.emplace_back(TriMesh{m.positions, {}, {}, {f}});
  const MeshDistance all(m);
  Rng rng(4);
  for (int i = 0; i < 300; ++i) {
    const Vec3f p{rng.normal(), rng.normal(), rng.normal()};
    float best = 1e9f;
    for (const MeshDistance& d : single) best = std::min(best, d.closest(p).distance);
    EXPECT_EQ(all.closest(p).distance, best);
  }
}

TEST(MeshDistance, EmptyMeshIsInfinitelyFar) {
  const std::vector<Vec3f> points{{0, 0, 0}};
  EXPECT_TRUE(std::isinf(MeshDistance(TriMesh{}).distances(points)[0]));
}

}  // namespace
}  // namespace vitrine
