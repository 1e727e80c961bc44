#include "stages/objects/detect.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/voxel_grid.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/scene/mesh/tsdf_volume.h"

namespace vitrine {

namespace {

constexpr int kSoftPadding = 4;  // cells around the bounds, so that the surface is closed
constexpr int kSoftening = 4;    // passes of a 1 2 1 filter over the field: silhouettes of some dozen photos give a faceted hull
constexpr int kFineSmoothing = 10;  // passes of Taubin smoothing over the mesh: removes the steps of the cells

void soften(VoxelGrid<float>& grid) {
  std::vector<float> before;
  for (int pass = 0; pass < kSoftening; ++pass)
    for (size_t axis = 0; axis < 3; ++axis) {
      before = grid.values;
      const size_t step = axis == 0 ? grid.index(1, 0, 0) : axis == 1 ? grid.index(0, 1, 0) : grid.index(0, 0, 1);
      grid.each([&](int x, int y, int z) {
        const int at = axis == 0 ? x : axis == 1 ? y : z;
        if (at == 0 || at + 1 == grid.size[axis]) return;
        const size_t i = grid.index(x, y, z);
        grid.values[i] = 0.25f * (before[i - step] + 2 * before[i] + before[i + step]);
      });
    }
}

TriMesh surface_of(const VoxelGrid<float>& grid) {
  const Vec3d half = 0.5 * grid.cell * Vec3d{1, 1, 1};
  TsdfVolume volume({.bounds = {grid.origin + half, grid.high() - half}, .voxel = grid.cell});
  volume.touch_all();
  volume.allocate();
  parallel_for(volume.block_count(), 8, [&](size_t b) {
    const BlockCoord& at = volume.coord(b);
    TsdfBlock& block = volume.block(b);
    for (int z = 0; z < TsdfBlock::kSide; ++z)
      for (int y = 0; y < TsdfBlock::kSide; ++y)
        for (int x = 0; x < TsdfBlock::kSide; ++x) {
          const int cell[] = {at.x * TsdfBlock::kSide + x, at.y * TsdfBlock::kSide + y, at.z * TsdfBlock::kSide + z};
          if (!grid.has(cell[0], cell[1], cell[2])) continue;
          const auto i = static_cast<size_t>(TsdfBlock::index(x, y, z));
          block.distance[i] = 1 - 2 * grid.at(cell[0], cell[1], cell[2]);
          block.weight[i] = 1;
        }
  });
  TriMesh mesh = iso_surface(volume);
  taubin_smooth(mesh, {.iterations = kFineSmoothing});
  mesh.normals = vertex_normals(mesh);
  return mesh;
}

// `occupancy`: of a point, 0 to 1.
TriMesh soft_surface(const Bounds3& bounds, double cell, const std::function<float(const Vec3d&)>& occupancy) {
  VoxelGrid<float> grid{bounds.low - kSoftPadding * cell * Vec3d{1, 1, 1}, cell, {}, {}};
  for (size_t c = 0; c < 3; ++c) grid.size[c] = int(std::ceil((bounds.high[c] - bounds.low[c]) / cell)) + 2 * kSoftPadding;
  grid.values.assign(grid.count(), 0.f);
  grid.each([&](int x, int y, int z) { grid.values[grid.index(x, y, z)] = occupancy(grid.centre(x, y, z)); });
  soften(grid);
  return surface_of(grid);
}

}  // namespace

TriMesh fine_hull(const Carving& carving, const Bounds3& bounds, double cell, const std::function<int(const Vec3d&)>& known) {
  return soft_surface(bounds, cell, [&](const Vec3d& p) {
    thread_local std::vector<float> scratch;
    const int certain = known(p);
    return certain >= 0 ? float(certain) : carving.occupancy(p, scratch);
  });
}

TriMesh hull_mesh(const VisualHull& hull) {
  if (hull.empty()) return {};
  const VoxelGrid<uint8_t>& carved = hull.carved();
  return soft_surface(hull.bounds(), carved.cell, [&](const Vec3d& p) { return carved.at(p) != 0 ? 1.f : 0.f; });
}

}  // namespace vitrine
