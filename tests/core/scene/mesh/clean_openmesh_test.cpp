#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/tri_mesh.h"
#include "tests/core/scene/mesh/shapes.h"

namespace vitrine {
namespace {

TEST(Components, TwoRoomsStayAndDustGoes) {
  TriMesh m = shapes::sphere({0, 0, 0}, 1, 20, 30);
  shapes::append(m, shapes::sphere({5, 0, 0}, 1, 18, 30));
  const size_t both = m.faces.size();
  shapes::append(m, shapes::sphere({2, 2, 0}, 0.01f, 2, 3));  // 6 of 2220 faces
  EXPECT_EQ(mesh_report(m).components, 3u);
  EXPECT_EQ(without_small_components(m, {.min_fraction = 0.005}).faces.size(), both);
  const TriMesh largest = without_small_components(m, {.min_fraction = 0, .keep_largest = 1});
  EXPECT_EQ(mesh_report(largest).components, 1u);
  EXPECT_LT(mesh_report(largest).bounds.high.x, 1.5);
}

TEST(Taubin, SmoothsNoiseAndKeepsTheVolume) {
  TriMesh m = shapes::sphere({0, 0, 0}, 1, 40, 60);
  const double volume = mesh_report(m).volume;
  Rng rng(5);
  for (Vec3f& p : m.positions) p *= 1 + 0.02f * rng.normal();
  const auto roughness = [&] {
    double sum = 0;
    for (const Vec3f& p : m.positions) sum += std::pow(length(p) - 1, 2);
    return std::sqrt(sum / double(m.positions.size()));
  };
  const double before = roughness();
  taubin_smooth(m, {.iterations = 5});
  EXPECT_LT(roughness(), 0.5 * before);
  EXPECT_NEAR(mesh_report(m).volume, volume, 0.02 * volume);
}

TEST(Taubin, KeepsTheOutlineOfAGrid) {
  TriMesh m = shapes::grid(10);
  taubin_smooth(m, {.iterations = 5});
  const Bounds3 b = mesh_report(m).bounds;
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_NEAR(b.low[i], 0, 0.03);
    EXPECT_NEAR(b.high[i], 1, 0.03);
  }
  EXPECT_NEAR(mesh_report(m).area, 1, 0.02);
}

TEST(Decimation, HitsTheTargetAndStaysOnTheSphere) {
  TriMesh m = shapes::sphere({0, 0, 0}, 1, 100, 150);
  for (const Vec3f& p : m.positions) m.colors.push_back(p), m.object_ids.push_back(p.z > 0);
  const TriMesh small = decimated(m, {.target_faces = 2000});
  const MeshReport r = mesh_report(small);
  EXPECT_LE(r.faces, 2000u);
  EXPECT_GE(r.faces, 1990u);
  EXPECT_TRUE(r.closed());
  EXPECT_NEAR(r.volume, mesh_report(m).volume, 0.04);  // seen: 0.028
  for (size_t v = 0; v < small.positions.size(); ++v) {
    EXPECT_EQ(small.colors[v], small.positions[v]);
    EXPECT_EQ(small.object_ids[v], small.positions[v].z > 0);
  }
  EXPECT_EQ(decimated(small, {.target_faces = 5000}).faces.size(), small.faces.size());
}

TEST(Decimation, KeepsCornersAndOutlineOfABoxAndAGrid) {
  TriMesh grid = shapes::grid(40);
  TriMesh flat = decimated(grid, {.target_faces = 100});
  MeshReport r = mesh_report(flat);
  EXPECT_LE(r.faces, 100u);
  EXPECT_NEAR(r.area, 1, 1e-5);  // a plane loses nothing, its corners least
  EXPECT_NEAR(r.bounds.high.x, 1, 1e-6);
  EXPECT_EQ(r.boundary_loops, 1u);
}

}  // namespace
}  // namespace vitrine
