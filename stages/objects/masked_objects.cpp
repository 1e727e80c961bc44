#include "stages/objects/detect.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/scene/camera/projection.h"
#include "core/foundation/math/connected_components.h"

namespace vitrine {

namespace {

constexpr size_t kSmallestPiece = 50;  // minimum size of a component: 1/50 of the largest
// Tolerance around the footprint of a hull, which may be smaller than its object: relative to the root of its area, and in
// pixels.
constexpr double kReach_rel = 0.25;
constexpr int kLeastReach = 3;

// [h,w] 1 where a cell projects to.
std::vector<uint8_t> footprint(const VoxelGrid<uint8_t>& grid, const std::vector<size_t>& cells, const View& view) {
  const Intrinsics& k = view.intrinsics;
  std::vector<uint8_t> out(k.pixel_count(), 0);
  for (const size_t cell : cells) {
    const auto [x, y, z] = grid.cell_at(cell);
    const auto p = projection(grid.centre(x, y, z), view, grid.cell);
    if (!p) continue;
    const double reach = 0.5 * std::sqrt(3.0) * grid.cell * k.fx / p->z;  // radius of the cell's bounding sphere, pixels
    const int left = std::max(0, int(p->x - reach)), right = std::min(k.width - 1, int(p->x + reach));
    const int top = std::max(0, int(p->y - reach)), bottom = std::min(k.height - 1, int(p->y + reach));
    for (int v = top; v <= bottom; ++v)
      for (int u = left; u <= right; ++u) out[size_t(v) * size_t(k.width) + size_t(u)] = 1;
  }
  return out;
}

// [h,w] dilation by a square of 2 `reach` + 1 pixels.
std::vector<uint8_t> dilated(const std::vector<uint8_t>& set, int width, int height, int reach) {
  const auto pass = [reach](const std::vector<uint8_t>& from, int lines, int length, size_t line_step, size_t step) {
    std::vector<uint8_t> out(from.size(), 0);
    for (int line = 0; line < lines; ++line) {
      const size_t first = size_t(line) * line_step;
      int last_set = -reach - 1;
      for (int i = 0; i < length; ++i) {
        if (from[first + size_t(i) * step]) last_set = i;
        if (i - last_set <= reach) out[first + size_t(i) * step] = 1;
      }
      last_set = length + reach;
      for (int i = length - 1; i >= 0; --i) {
        if (from[first + size_t(i) * step]) last_set = i;
        if (last_set - i <= reach) out[first + size_t(i) * step] = 1;
      }
    }
    return out;
  };
  const auto w = static_cast<size_t>(width);
  return pass(pass(set, height, width, w, 1), width, height, 1, w);
}

// Silhouettes of one component. Pixels explained only by others become unknown, and so do marked pixels far from it: they show
// another object, perhaps one whose hull an occluder has cut, or one without a hull.
std::vector<Silhouette> without_others(const std::vector<Silhouette>& all, const VoxelGrid<uint8_t>& grid,
                                       const std::vector<std::vector<size_t>>& pieces, size_t own) {
  std::vector<size_t> others;
  for (size_t p = 0; p < pieces.size(); ++p)
    if (p != own) others.insert(others.end(), pieces[p].begin(), pieces[p].end());
  std::vector<Silhouette> out = all;
  parallel_for(out.size(), 1, [&](size_t i) {
    const auto mine = footprint(grid, pieces[own], out[i].view), theirs = footprint(grid, others, out[i].view);
    const Intrinsics& k = out[i].view.intrinsics;
    const double area = static_cast<double>(std::ranges::count(mine, 1));
    const auto near = dilated(mine, k.width, k.height, std::max(kLeastReach, int(kReach_rel * std::sqrt(area))));
    for (size_t pixel = 0; pixel < mine.size(); ++pixel) {
      float& value = out[i].value.data()[pixel];
      if (!mine[pixel] && (theirs[pixel] || (value >= 0.5f && !near[pixel]))) value = -1;
    }
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
  const size_t largest = std::ranges::max(parts.members, {}, &std::vector<size_t>::size).size();
  HullDesc piece = desc;
  piece.one_piece = true;
  for (size_t p = 0; p < parts.members.size(); ++p) {
    if (kSmallestPiece * parts.members[p].size() < largest) continue;
    MaskedObject object{kind, without_others(silhouettes, grid, parts.members, p), {}};
    object.hull = VisualHull(object.silhouettes, piece);
    if (!object.hull.empty()) out.push_back(std::move(object));
  }
  return out;
}

}  // namespace vitrine
