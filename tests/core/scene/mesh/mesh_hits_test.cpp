// Mesh ray queries against what geometry says.
#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/scene/mesh/mesh_hits.h"
#include "tests/core/scene/mesh/shapes.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

TEST(MeshHits, FirstHitOfASphereIsTheAnalyticOne) {
  const float radius = 0.7f;
  const MeshHits mesh(shapes::sphere({0.1f, 0.2f, -0.1f}, radius, 200, 300));
  Rng rng(1);
  int hits = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3f origin = 3.f * normalized(Vec3f{rng.normal(), rng.normal(), rng.normal()});
    const Vec3f direction = normalized(Vec3f{0.4f * rng.normal(), 0.4f * rng.normal(), 0.4f * rng.normal()} - origin);
    const Vec3f to_origin = origin - Vec3f{0.1f, 0.2f, -0.1f};
    const float b = dot(to_origin, direction), c = dot(to_origin, to_origin) - radius * radius, root = b * b - c;
    const auto hit = mesh.first_hit(origin, direction);
    if (root < 0.01f) continue;  // beside it, or at the silhouette, where a polygon is not a sphere
    ASSERT_TRUE(hit.has_value());
    ++hits;
    EXPECT_NEAR(hit->t, -b - std::sqrt(root), 2e-3f);
    EXPECT_FALSE(hit->from_inside);
    EXPECT_GT(dot(hit->normal, normalized(to_origin + hit->t * direction)), 0.999f);
    const auto back = mesh.back_surface(origin, direction, hit->t + 1e-3f);
    ASSERT_TRUE(back.has_value());
    EXPECT_NEAR(back->t, -b + std::sqrt(root), 2e-3f);
    EXPECT_TRUE(back->from_inside);
    EXPECT_FALSE(mesh.occluded(origin, direction, 0, hit->t - 1e-3f));
    EXPECT_TRUE(mesh.occluded(origin, direction, 0, hit->t + 1e-3f));
  }
  EXPECT_GT(hits, 500);
}

TEST(MeshHits, WeightsOfTheCornersGiveThePlace) {
  const TriMesh sphere = shapes::sphere({0, 0, 0}, 1, 20, 30);
  const MeshHits mesh(sphere);
  Rng rng(2);
  for (int i = 0; i < 500; ++i) {
    const Vec3f origin{0.1f * rng.normal(), 0.1f * rng.normal(), 0.1f * rng.normal()};
    const Vec3f direction = normalized(Vec3f{rng.normal(), rng.normal(), rng.normal()});
    const auto hit = mesh.first_face(origin, direction);
    ASSERT_TRUE(hit.has_value());
    EXPECT_TRUE(hit->from_inside);
    const auto& f = sphere.faces[hit->face];
    const Vec3f place =
        (1 - hit->u - hit->v) * sphere.positions[f[0]] + hit->u * sphere.positions[f[1]] + hit->v * sphere.positions[f[2]];
    EXPECT_LT(length(place - (origin + hit->t * direction)), 1e-5f);
  }
}

TEST(MeshHits, PanesShareTheLightAndSolidThingsStopIt) {
  TriMesh shells = shapes::sphere({0, 0, 0}, 1, 20, 30);
  const size_t outer = shells.faces.size();
  shapes::append(shells, shapes::sphere({0, 0, 0}, 0.5f, 20, 30));
  const MeshHits mesh(shells);
  std::vector<float> of_faces(shells.faces.size(), 0.5f);
  std::fill(of_faces.begin() + std::ptrdiff_t(outer), of_faces.end(), 0.8f);
  const Vec3f from{0.03f, 0.02f, -3}, direction{0, 0, 1};
  const auto through = [&](float far, float least = 0.01f) {
    return mesh.transmittance(from, direction, far, {of_faces, least, 1e-5f});
  };
  EXPECT_EQ(through(1.5f), 1);
  EXPECT_FLOAT_EQ(through(2.2f), 0.5f);
  EXPECT_FLOAT_EQ(through(3), 0.5f * 0.8f);
  EXPECT_FLOAT_EQ(through(MeshHits::kFar), 0.5f * 0.8f * 0.8f * 0.5f);
  EXPECT_EQ(through(MeshHits::kFar, 0.2f), 0);
  // A ray through a pole meets thirty faces that are one surface.
  EXPECT_FLOAT_EQ(mesh.transmittance({0, 0, -3}, direction, 2.2f, {of_faces, 0.01f, 1e-5f}), 0.5f);
  EXPECT_FLOAT_EQ(mesh.transmittance({0, 0, -3}, direction, MeshHits::kFar, {of_faces, 0.01f, 1e-5f}), 0.5f * 0.8f * 0.8f * 0.5f);
  std::fill(of_faces.begin() + std::ptrdiff_t(outer), of_faces.end(), 0.f);
  EXPECT_EQ(through(MeshHits::kFar, 0.f), 0);
  EXPECT_FLOAT_EQ(through(2.2f), 0.5f);
}

TEST(MeshHits, BackSurfaceSkipsAShellInsideTheShell) {
  TriMesh mesh = shapes::sphere({0, 0, 0}, 1, 40, 60);
  shapes::append(mesh, shapes::sphere({0, 0, 0}, 0.5f, 40, 60));
  const MeshHits nested(mesh);
  const Vec3f origin{0.01f, 0.02f, -3}, direction{0, 0, 1};
  const auto front = nested.first_hit(origin, direction);
  ASSERT_TRUE(front.has_value());
  EXPECT_NEAR(front->t, 2, 0.01f);
  const auto back = nested.back_surface(origin, direction, front->t + 0.01f);
  ASSERT_TRUE(back.has_value());
  EXPECT_NEAR(back->t, 4, 0.01f);
}

TEST(MeshHits, BackSurfaceOfAnOpenShellIsTheLastBackOrNone) {
  const MeshHits pane(shapes::grid(4));  // faces +z
  EXPECT_FALSE(pane.back_surface({0.3f, 0.4f, 2}, {0, 0, -1}, 2.01f).has_value());
  TriMesh bowl = shapes::cube();
  std::erase_if(bowl.faces, [&](const auto& f) {  // without its top
    return bowl.positions[f[0]].z + bowl.positions[f[1]].z + bowl.positions[f[2]].z > 2.5f;
  });
  ASSERT_EQ(bowl.faces.size(), 10u);
  const auto back = MeshHits(bowl).back_surface({0.4f, 0.3f, 3}, {0, 0, -1}, 0);
  ASSERT_TRUE(back.has_value());
  EXPECT_NEAR(back->t, 3, 1e-5f);
}

TEST(MeshHits, AnEdgeIsOneSurfaceAndTheSmallestFaceWins) {
  const MeshHits mesh(shapes::cube());
  // Through the diagonals of top and bottom: both triangles of each are met.
  const auto top = mesh.first_hit({0.5f, 0.5f, 3}, {0, 0, -1});
  ASSERT_TRUE(top.has_value());
  EXPECT_EQ(top->face, 2u);
  const auto back = mesh.back_surface({0.5f, 0.5f, 3}, {0, 0, -1}, top->t + 0.1f);
  ASSERT_TRUE(back.has_value());
  EXPECT_NEAR(back->t, 3, 1e-5f);
  EXPECT_EQ(back->face, 0u);
}

TEST(MeshHits, RefusesAFaceWithoutItsVertexAndTakesAnEmptyMesh) {
  TriMesh broken = shapes::cube();
  broken.faces.push_back({0, 1, 99});
  EXPECT_EQ(error_of([&] { MeshHits hits(broken); }).kind(), ErrorKind::Input);
  EXPECT_FALSE(MeshHits(TriMesh{}).first_hit({0, 0, 0}, {0, 0, 1}).has_value());
}

}  // namespace
}  // namespace vitrine
