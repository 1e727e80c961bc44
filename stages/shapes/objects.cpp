#include "stages/shapes/objects.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "core/math/connected_components.h"

namespace vitrine {

namespace {

constexpr size_t kSmallestPiece = 50;  // one part in, of the largest one

// [h,w] 1 where the view shows one of the cells.
std::vector<uint8_t> footprint(const VoxelGrid<uint8_t>& grid, const std::vector<size_t>& cells, const View& view) {
  const Intrinsics& k = view.intrinsics;
  std::vector<uint8_t> out(size_t(k.width) * size_t(k.height), 0);
  for (const size_t cell : cells) {
    const auto [x, y, z] = grid.cell_at(cell);
    const auto p = projection(grid.centre(x, y, z), view, grid.cell);
    if (!p) continue;
    const double reach = 0.5 * std::sqrt(3.0) * grid.cell * k.fx / p->z;  // of the ball around the cell
    const int left = std::max(0, int(p->x - reach)), right = std::min(k.width - 1, int(p->x + reach));
    const int top = std::max(0, int(p->y - reach)), bottom = std::min(k.height - 1, int(p->y + reach));
    for (int v = top; v <= bottom; ++v)
      for (int u = left; u <= right; ++u) out[size_t(v) * size_t(k.width) + size_t(u)] = 1;
  }
  return out;
}

// Silhouettes in which pixels that other pieces alone account for are unknown.
std::vector<Silhouette> without_others(const std::vector<Silhouette>& all, const VoxelGrid<uint8_t>& grid,
                                       const std::vector<std::vector<size_t>>& pieces, size_t own) {
  std::vector<size_t> others;
  for (size_t p = 0; p < pieces.size(); ++p)
    if (p != own) others.insert(others.end(), pieces[p].begin(), pieces[p].end());
  std::vector<Silhouette> out = all;
  parallel_for(out.size(), 1, [&](size_t i) {
    const auto mine = footprint(grid, pieces[own], out[i].view), theirs = footprint(grid, others, out[i].view);
    for (size_t pixel = 0; pixel < mine.size(); ++pixel)
      if (theirs[pixel] && !mine[pixel]) out[i].value.data()[pixel] = -1;
  });
  return out;
}

}  // namespace

std::vector<MaskedObject> masked_objects(MaskClass kind, const std::vector<Silhouette>& silhouettes, const HullDesc& desc) {
  std::vector<MaskedObject> out;
  VisualHull hull(silhouettes, desc);
  if (hull.empty()) return out;
  const VoxelGrid<uint8_t>& grid = hull.carved();
  const ConnectedComponents parts = connected_components(grid, [&](size_t i) { return grid.values[i] != 0; });
  if (parts.members.size() == 1) {
    out.push_back({kind, silhouettes, std::move(hull)});
    return out;
  }
  const size_t largest = std::ranges::max(parts.members, {}, &std::vector<size_t>::size).size();
  size_t count = 0;
  for (const auto& members : parts.members) count += kSmallestPiece * members.size() >= largest;
  HullDesc piece = desc;
  piece.one_piece = true;
  for (size_t p = 0; p < parts.members.size(); ++p) {
    if (kSmallestPiece * parts.members[p].size() < largest) continue;
    MaskedObject object{kind, count > 1 ? without_others(silhouettes, grid, parts.members, p) : silhouettes, {}};
    object.hull = VisualHull(object.silhouettes, piece);
    if (!object.hull.empty()) out.push_back(std::move(object));
  }
  return out;
}

}  // namespace vitrine
