#include "core/scene/mesh/tetrahedra_surface.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

// A grid of cubes, each cut into six tetrahedra around its diagonal (Kuhn): neighbours share whole faces.
template <class F>
Tetrahedra grid_of(int n, F value) {
  Tetrahedra t;
  const auto id = [&](int x, int y, int z) { return uint32_t((z * (n + 1) + y) * (n + 1) + x); };
  for (int z = 0; z <= n; ++z)
    for (int y = 0; y <= n; ++y)
      for (int x = 0; x <= n; ++x) {
        t.positions.push_back({double(x), double(y), double(z)});
        const bool border = x == 0 || y == 0 || z == 0 || x == n || y == n || z == n;
        t.values.push_back(border ? 1 : value(t.positions.back()));
      }
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < n; ++x)
        for (const auto& [a, b] : {std::pair{0, 1}, {1, 2}, {2, 0}, {1, 0}, {2, 1}, {0, 2}}) {
          std::array<int, 3> p{x, y, z};
          std::array<uint32_t, 4> cell{};
          cell[0] = id(p[0], p[1], p[2]);
          ++p[size_t(a)];
          cell[1] = id(p[0], p[1], p[2]);
          ++p[size_t(b)];
          cell[2] = id(p[0], p[1], p[2]);
          cell[3] = id(x + 1, y + 1, z + 1);
          if ((b - a + 3) % 3 == 2) std::swap(cell[1], cell[2]);
          t.cells.push_back(cell);
        }
  return t;
}

TEST(TetrahedraSurface, OfABallIsClosedAndFacesOutwards) {
  const Vec3d centre{5.1, 5.2, 4.9};
  const TriMesh mesh = zero_level(grid_of(10, [&](const Vec3d& p) { return length(p - centre) - 3.3; }));
  const MeshReport r = mesh_report(mesh);
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.manifold_edges, r.edges);
  EXPECT_EQ(r.euler, 2);
  EXPECT_NEAR(r.volume, 4.18879 * 3.3 * 3.3 * 3.3, 8);
  for (const Vec3f& p : mesh.positions) EXPECT_NEAR(length(cast<double>(p) - centre), 3.3, 0.15);
}

TEST(TetrahedraSurface, OfNoiseIsAClosedManifold) {
  Rng rng(1);
  const Tetrahedra t = grid_of(9, [&](const Vec3d&) { return rng.normal(); });  // every case
  const TriMesh mesh = zero_level(t);
  const MeshReport r = mesh_report(mesh);
  EXPECT_GT(r.faces, 4000u);
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.manifold_edges, r.edges);
  EXPECT_EQ(r.degenerate_faces, 0u);
  EXPECT_EQ(r.loose_vertices, 0u);
  // Faces look to the positive side: the volume inside is that of the negative parts.
  EXPECT_GT(r.volume, 0);
}

TEST(TetrahedraSurface, DoesNotDependOnTheOrderOfCells) {
  Rng rng(2);
  Tetrahedra t = grid_of(5, [&](const Vec3d&) { return rng.normal(); });
  const TriMesh mesh = zero_level(t);
  std::reverse(t.cells.begin(), t.cells.end());
  for (auto& v : t.cells) v = {v[1], v[2], v[0], v[3]};  // an even permutation
  const TriMesh other = zero_level(t);
  EXPECT_EQ(mesh.positions, other.positions);
  EXPECT_EQ(mesh.faces, other.faces);
}

TEST(TetrahedraSurface, ZeroIsOutside) {
  const TriMesh mesh = zero_level(grid_of(4, [](const Vec3d& p) { return p == Vec3d{2, 2, 2} ? -1.0 : 0.0; }));
  EXPECT_TRUE(mesh_report(mesh).closed());
  EXPECT_EQ(mesh_report(mesh).components, 1u);
  EXPECT_TRUE(zero_level(grid_of(4, [](const Vec3d&) { return 0.0; })).faces.empty());
}

}  // namespace
}  // namespace vitrine
