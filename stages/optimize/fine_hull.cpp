#include "stages/optimize/fine_hull.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "core/math/quantile.h"
#include "core/math/voxel_grid.h"
#include "core/mesh/clean_openmesh.h"
#include "core/mesh/iso_surface.h"

namespace vitrine {

namespace {

constexpr int kSoftPadding = 4;  // cells around the bounds, so that the surface closes
constexpr int kSoftening = 4;    // passes of 1 2 1 over the field: outlines of some dozen photos are facets
constexpr float kHullLevel = 0.5f;
constexpr int kFineSmoothing = 10;  // Taubin's passes over the mesh: what is left of the cells' steps

// Mask values between pixel centres; a pixel of another class has no say. Negative: none at all.
float softly(const HullJudge& judge, double x, double y) {
  const Intrinsics& k = judge.view->intrinsics;
  const double u = std::clamp(x - 0.5, 0.0, double(k.width - 1)), v = std::clamp(y - 0.5, 0.0, double(k.height - 1));
  const int left = std::max(std::min(int(u), k.width - 2), 0), top = std::max(std::min(int(v), k.height - 2), 0);
  double sum = 0, weights = 0;
  for (int j = 0; j < 2; ++j)
    for (int i = 0; i < 2; ++i) {
      const size_t pixel = size_t(std::min(top + j, k.height - 1)) * size_t(k.width) + size_t(std::min(left + i, k.width - 1));
      if (!judge.says.other.empty() && judge.says.other[pixel] >= 128) continue;
      const double w = (i ? u - left : 1 - (u - left)) * (j ? v - top : 1 - (v - top));
      sum += w * double(judge.says.mask[pixel]) / 255, weights += w;
    }
  return weights > 0 ? static_cast<float>(sum / weights) : -1.f;
}

// How far inside: what all but the share that may err agree on.
float soft_occupancy(const std::vector<HullJudge>& judges, const Vec3d& p, std::vector<float>& said) {
  said.clear();
  int seen = 0, inside = 0;
  for (const HullJudge& judge : judges) {
    const auto q = image_point(p, *judge.view);
    if (!q) continue;
    const float value = softly(judge, q->x, q->y);
    if (value < 0) continue;
    ++seen;
    inside += value >= kHullLevel;
    const float depth = judge.depth[size_t(q->y) * size_t(judge.view->intrinsics.width) + size_t(q->x)];
    if (value >= kHullLevel || !(depth > 0 && depth < kHullInFront * float(q->z))) said.push_back(value);
  }
  if (inside < kHullFewestPhotos || inside < kHullSeenShare * double(judges.size()) || inside < kHullInsideShare * seen) return 0;
  return order_statistic_of(std::span(said), size_t(kHullOutsideShare * double(said.size())));
}

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
  return mesh;
}

}  // namespace

FineHull fine_hull(const std::vector<HullJudge>& judges, const Bounds3& bounds, double cell,
                   const std::function<int(const Vec3d&)>& known) {
  VoxelGrid<float> grid{bounds.low - kSoftPadding * cell * Vec3d{1, 1, 1}, cell, {}, {}};
  for (size_t c = 0; c < 3; ++c) grid.size[c] = int(std::ceil((bounds.high[c] - bounds.low[c]) / cell)) + 2 * kSoftPadding;
  grid.values.assign(grid.count(), 0.f);
  grid.each([&](int x, int y, int z) {
    thread_local std::vector<float> said;
    const Vec3d p = grid.centre(x, y, z);
    const int told = known(p);
    grid.values[grid.index(x, y, z)] = told >= 0 ? float(told) : soft_occupancy(judges, p, said);
  });
  soften(grid);
  std::vector<std::vector<HullSurfacePoint>> slices(size_t(grid.size[2]));
  const size_t across[] = {grid.index(1, 0, 0), grid.index(0, 1, 0), grid.index(0, 0, 1)};
  grid.each([&](int x, int y, int z) {
    const int at[] = {x, y, z};
    for (size_t c = 0; c < 3; ++c)
      if (at[c] < 2 || at[c] + 2 >= grid.size[c]) return;
    const size_t i = grid.index(x, y, z);
    const float here = grid.values[i];
    if (here < kHullLevel) return;
    bool last = false;
    Vec3d slope{};
    for (size_t c = 0; c < 3; ++c) {
      const float before = grid.values[i - across[c]], after = grid.values[i + across[c]];
      last |= before < kHullLevel || after < kHullLevel;
      slope[c] = double(after - before) / (2 * cell);
    }
    if (!last || !(length(slope) > 0)) return;
    const double steep = length(slope), down = std::min(double(here - kHullLevel) / steep, cell);
    const Vec3d outwards = -slope / steep;
    slices[size_t(z)].push_back({grid.centre(x, y, z) + down * outwards, outwards});
  });
  FineHull out;
  for (const auto& slice : slices) out.points.insert(out.points.end(), slice.begin(), slice.end());
  out.mesh = surface_of(grid);
  return out;
}

}  // namespace vitrine
