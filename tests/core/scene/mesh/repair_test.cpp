#include <gtest/gtest.h>

#include "core/scene/mesh/repair_cgal.h"
#include "core/scene/mesh/tri_mesh.h"
#include "tests/core/scene/mesh/shapes.h"

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

}  // namespace
}  // namespace vitrine
