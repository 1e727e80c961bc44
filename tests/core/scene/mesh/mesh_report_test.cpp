#include "core/scene/mesh/tri_mesh.h"

#include <gtest/gtest.h>

#include "core/scene/mesh/mesh_topology.h"
#include "tests/core/scene/mesh/shapes.h"

namespace vitrine {
namespace {

TEST(MeshReport, KnowsTheUnitCube) {
  const MeshReport r = mesh_report(shapes::cube());
  EXPECT_EQ(r.faces, 12u);
  EXPECT_EQ(r.vertices, 8u);
  EXPECT_EQ(r.edges, 18u);
  EXPECT_EQ(r.manifold_edges, 18u);
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.euler, 2);
  EXPECT_NEAR(r.volume, 1, 1e-12);
  EXPECT_NEAR(r.area, 6, 1e-12);
  EXPECT_TRUE(r.closed());
}

TEST(MeshReport, CountsBoundariesOfAnOpenGridAndACubeWithoutLid) {
  MeshReport r = mesh_report(shapes::grid(5));
  EXPECT_EQ(r.boundary_edges, 20u);
  EXPECT_EQ(r.boundary_loops, 1u);
  EXPECT_EQ(r.euler, 1);
  EXPECT_FALSE(r.closed());
  TriMesh box = shapes::cube();
  box.faces.erase(box.faces.begin(), box.faces.begin() + 4);  // without bottom and top
  r = mesh_report(box);
  EXPECT_EQ(r.boundary_loops, 2u);
  EXPECT_EQ(r.boundary_edges, 8u);
}

TEST(MeshReport, FlagsWhatIsWrong) {
  TriMesh m = shapes::cube();
  m.faces.push_back({0, 2, 1});  // a duplicate: three edges have too many faces
  m.faces.push_back({5, 5, 6});  // degenerate
  m.positions.push_back({9, 9, 9});
  const MeshReport r = mesh_report(m);
  EXPECT_EQ(r.nonmanifold_edges, 4u);  // and the doubled side 5-6
  EXPECT_EQ(r.degenerate_faces, 1u);
  EXPECT_EQ(r.loose_vertices, 1u);
  EXPECT_LT(r.bounds.high.x, 2);
  TriMesh flipped = shapes::cube();
  std::swap(flipped.faces[0][1], flipped.faces[0][2]);
  EXPECT_EQ(mesh_report(flipped).nonmanifold_edges, 3u);  // two faces, same direction
}

TEST(MeshReport, CountsComponents) {
  TriMesh m = shapes::cube();
  shapes::append(m, shapes::sphere({5, 0, 0}, 1, 8, 9));
  const MeshReport r = mesh_report(m);
  EXPECT_EQ(r.components, 2u);
  EXPECT_EQ(r.largest_component, shapes::sphere({}, 1, 8, 9).faces.size());
}

TEST(VertexNormals, OfASpherePointOutwards) {
  const TriMesh m = shapes::sphere({1, 1, 1}, 2, 24, 48);
  const std::vector<Vec3f> n = vertex_normals(m);
  for (size_t v = 0; v < n.size(); ++v) EXPECT_GT(dot(n[v], m.normals[v]), 0.99f);
  for (const Vec3f& c : vertex_normals(shapes::cube()))  // independent of the diagonals of the sides
    EXPECT_NEAR(std::abs(c.x) + std::abs(c.y) + std::abs(c.z), std::sqrt(3.f), 1e-5);
}

}  // namespace
}  // namespace vitrine
