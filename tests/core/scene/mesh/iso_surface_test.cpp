#include "core/scene/mesh/tsdf_volume.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/mesh/cell_cases.h"
#include "core/scene/mesh/tri_mesh.h"

namespace vitrine {
namespace {

// A dense field over [0, 23]^3 voxels of edge 1 (27 blocks).
TsdfVolume field(const std::function<float(const Vec3d&)>& distance) {
  TsdfVolume volume({.bounds = {{0, 0, 0}, {23, 23, 23}}, .voxel = 1});
  volume.touch_all();
  volume.allocate();
  for (size_t b = 0; b < volume.block_count(); ++b)
    for (int z = 0; z < 8; ++z)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 8; ++x) {
          const int i = TsdfBlock::index(x, y, z);
          volume.block(b).distance[i] = distance(volume.voxel_position(volume.coord(b), x, y, z));
          volume.block(b).weight[i] = 1;
        }
  return volume;
}

bool on_border(const Vec3d& p) {
  for (size_t i = 0; i < 3; ++i)
    if (p[i] <= 0 || p[i] >= 23) return true;
  return false;
}

TEST(CellCases, EveryCaseUsesEachCrossingOnALoop) {
  for (int c = 0; c < 256; ++c)
    for (int joined = 0; joined < 64; ++joined) {
      if (joined & ~ambiguous_faces(uint8_t(c))) continue;
      const CellCase& cell = cell_case(uint8_t(c), uint8_t(joined));
      std::array<int, kCellEdges> uses{};
      for (const auto& t : cell.triangles)
        for (uint8_t v : t)
          if (v < kCellEdges) ++uses[v];
      for (int e = 0; e < kCellEdges; ++e) {
        const int c0 = cell_edge_corner(e), c1 = c0 | 1 << cell_edge_axis(e);
        EXPECT_EQ(uses[size_t(e)] > 0, ((c >> c0) & 1) != ((c >> c1) & 1))
            << "case " << c << " joined " << joined << " edge " << e;
      }
    }
}

// Noise has every case with every ambiguity. Outside at the border, the surface must be closed, each edge with two faces.
TEST(IsoSurface, IsAClosedManifoldOnRandomFields) {
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const TsdfVolume volume = field([&](const Vec3d& p) {
      Rng rng(seed, mix64(uint64_t(p.x), mix64(uint64_t(p.y), uint64_t(p.z))));
      return on_border(p) ? 1.f : 2 * rng.uniform() - 1;
    });
    const MeshReport r = mesh_report(iso_surface(volume));
    EXPECT_GT(r.faces, 20000u);
    EXPECT_EQ(r.boundary_edges, 0u);
    EXPECT_EQ(r.nonmanifold_edges, 0u);
    EXPECT_EQ(r.degenerate_faces, 0u);
    EXPECT_EQ(r.loose_vertices, 0u);
    EXPECT_GT(r.volume, 0);  // faces look outwards
  }
}

TEST(IsoSurface, FindsASphereWithItsNormals) {
  const Vec3d centre{11.3, 11.6, 11.1};
  const double radius = 7.2;
  const TriMesh mesh = iso_surface(field([&](const Vec3d& p) { return float((length(p - centre) - radius) / 4); }));
  const MeshReport r = mesh_report(mesh);
  EXPECT_TRUE(r.closed());
  EXPECT_EQ(r.components, 1u);
  EXPECT_EQ(r.euler, 2);
  EXPECT_NEAR(r.volume, 4.0 / 3 * M_PI * radius * radius * radius, 0.02 * r.volume);
  double worst = 0, worst_cosine = 1;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    const Vec3d n = cast<double>(mesh.positions[v]) - centre;
    worst = std::max(worst, std::abs(length(n) - radius));
    worst_cosine = std::min(worst_cosine, dot(normalized(n), cast<double>(mesh.normals[v])));
  }
  EXPECT_LT(worst, 0.05);  // seen: 0.017 voxels
  EXPECT_GT(worst_cosine, 0.995);
}

TEST(IsoSurface, SeparatesOrJoinsADiagonalByTheSaddle) {
  // Two inside points on the diagonal of a face, at every position in the volume: strong ones join, weak ones stay apart.
  for (float strength : {0.2f, 5.f}) {
    const TsdfVolume volume = field([&](const Vec3d& p) {
      const bool dip = p == Vec3d{7, 7, 7} || p == Vec3d{8, 8, 7};
      return dip ? -strength : 1.f;
    });
    EXPECT_EQ(mesh_report(iso_surface(volume)).components, strength > 1 ? 1u : 2u);
  }
}

TEST(IsoSurface, GivesNoSurfaceWhereNobodyLooked) {
  TsdfVolume volume = field([](const Vec3d& p) { return float(p.z - 11.5) / 4; });
  EXPECT_EQ(mesh_report(iso_surface(volume)).faces, size_t(23 * 23 * 2));
  for (size_t b = 0; b < volume.block_count(); ++b)
    if (volume.coord(b).x == 1) volume.block(b).weight.fill(0);
  const MeshReport r = mesh_report(iso_surface(volume));
  EXPECT_EQ(r.faces, size_t((7 + 7) * 23 * 2));  // cells that touch the unseen slab are gone
  EXPECT_EQ(r.components, 2u);
  EXPECT_EQ(r.loose_vertices, 0u);
}

TEST(IsoSurface, SameMeshForAnyNumberOfThreads) {
  const TsdfVolume volume =
      field([](const Vec3d& p) { return float(std::sin(0.9 * p.x) + std::sin(1.1 * p.y) + std::sin(p.z)); });
  set_thread_limit(1);
  const TriMesh one = iso_surface(volume);
  set_thread_limit(8);
  const TriMesh many = iso_surface(volume);
  set_thread_limit(0);
  EXPECT_EQ(one.positions, many.positions);
  EXPECT_EQ(one.normals, many.normals);
  EXPECT_EQ(one.faces, many.faces);
}

}  // namespace
}  // namespace vitrine
