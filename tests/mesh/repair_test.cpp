#include <gtest/gtest.h>

#include "core/base/rng.h"
#include "core/mesh/clean_openmesh.h"
#include "core/mesh/mesh_distance.h"
#include "core/mesh/mesh_report.h"
#include "core/mesh/repair_cgal.h"
#include "tests/mesh/shapes.h"

namespace vitrine {
namespace {

// Each face with corners of its own.
TriMesh soup_of(const TriMesh& mesh) {
  TriMesh m;
  for (const auto& f : mesh.faces) {
    const uint32_t base = static_cast<uint32_t>(m.positions.size());
    for (uint32_t v : f) {
      m.positions.push_back(mesh.positions[v]);
      m.colors.push_back(mesh.positions[v]);
    }
    m.faces.push_back({base, base + 1, base + 2});
  }
  return m;
}

TEST(Repair, MakesASphereOfADamagedSoup) {
  const TriMesh sphere = shapes::sphere({0, 0, 0}, 1, 20, 30);
  TriMesh bad = soup_of(sphere);
  bad.faces.erase(bad.faces.begin() + 300, bad.faces.begin() + 306);  // holes
  bad.faces.erase(bad.faces.begin() + 800, bad.faces.begin() + 801);
  for (size_t f = 0; f < bad.faces.size(); f += 3) std::swap(bad.faces[f][0], bad.faces[f][1]);  // wrong sides
  bad.faces.push_back(bad.faces[5]);                                                             // a duplicate
  bad.faces.push_back({bad.faces[7][1], bad.faces[7][0], bad.faces[7][2]});
  bad.faces.push_back({3, 3, 4});  // degenerate ones
  bad.faces.push_back({0, 1, 0});
  bad.positions.push_back({100, 100, 100});  // loose
  bad.colors.push_back({0, 0, 0});
  RepairReport report;
  const TriMesh good = repaired(bad, {}, &report);
  const MeshReport r = mesh_report(good);
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.euler, 2);
  EXPECT_EQ(r.vertices, sphere.positions.size());
  EXPECT_NEAR(r.volume, mesh_report(sphere).volume, 0.01);
  EXPECT_EQ(report.filled_holes, 2u);
  EXPECT_EQ(report.dropped_faces, 4u);
  EXPECT_EQ(self_intersection_count(good), 0u);
  for (size_t v = 0; v < good.positions.size(); ++v)
    EXPECT_EQ(good.colors[v], good.positions[v]);  // colours stay with their vertex
}

TEST(Repair, LeavesHolesThatAreTooLong) {
  TriMesh m = shapes::sphere({0, 0, 0}, 1, 20, 30);
  m.faces.erase(m.faces.begin(), m.faces.begin() + 30);  // a polar cap: a hole of 30 edges
  EXPECT_EQ(mesh_report(repaired(m, {.max_hole_edges = 29})).boundary_edges, 30u);
  EXPECT_TRUE(mesh_report(repaired(m, {.max_hole_edges = 30})).closed());
}

TEST(Repair, RemovesSelfIntersections) {
  TriMesh m = shapes::sphere({0, 0, 0}, 1, 24, 36);
  m.positions[400] = {-2.f * m.positions[400].x, -2.f * m.positions[400].y,
                      -2.f * m.positions[400].z};  // a spike through the other side
  EXPECT_GT(self_intersection_count(m), 0u);
  RepairReport report;
  const TriMesh good = repaired(m, {}, &report);
  EXPECT_GT(report.intersecting_faces, 0u);
  EXPECT_EQ(self_intersection_count(good), 0u);
  EXPECT_TRUE(mesh_report(good).closed());
  EXPECT_NEAR(mesh_report(good).volume, 4.1, 0.15);
}

TEST(Repair, SideFollowsTheNormalsAlsoForACavity) {
  TriMesh m = shapes::sphere({0, 0, 0}, 1, 12, 16);
  for (Vec3f& n : m.normals) n = -n;  // air inside
  for (auto& f : m.faces) std::swap(f[0], f[1]);
  EXPECT_LT(mesh_report(repaired(m, {})).volume, -3);
  m.normals.clear();
  EXPECT_GT(mesh_report(repaired(m, {})).volume, 3);
}

TEST(Repair, OpensNonManifoldEdges) {
  TriMesh m = shapes::grid(4);
  const uint32_t top = static_cast<uint32_t>(m.positions.size());
  m.positions.push_back({0.5f, 0.5f, 1});
  m.faces.push_back({6, 7, top});  // a fin on an inner edge
  EXPECT_EQ(mesh_report(m).nonmanifold_edges, 1u);
  const TriMesh open = repaired(m, {.max_hole_edges = 0});
  EXPECT_EQ(mesh_report(open).nonmanifold_edges, 0u);
  EXPECT_EQ(open.faces.size(), m.faces.size());  // touching is not crossing
  EXPECT_EQ(self_intersection_count(open), 0u);
}

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
  for (const Vec3f& p : m.positions) m.colors.push_back(p);
  const TriMesh small = decimated(m, {.target_faces = 2000});
  const MeshReport r = mesh_report(small);
  EXPECT_LE(r.faces, 2000u);
  EXPECT_GE(r.faces, 1990u);
  EXPECT_TRUE(r.closed());
  EXPECT_NEAR(r.volume, mesh_report(m).volume, 0.04);  // seen: 0.028
  for (size_t v = 0; v < small.positions.size(); ++v) EXPECT_EQ(small.colors[v], small.positions[v]);
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
