#include "stages/optimize/hull.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/log.h"
#include "core/base/parallel.h"
#include "core/camera/projection.h"
#include "core/math/quantile.h"
#include "core/math/voxel_grid.h"
#include "core/stereo/box_fit.h"
#include "core/stereo/flat_faces.h"
#include "core/stereo/revolution_fit.h"
#include "stages/optimize/hull_judges.h"
#include "stages/optimize/hull_things.h"

namespace vitrine {

namespace {

constexpr double kPercentile = 0.02, kMargin = 0.2;  // of the sparse points: where things are looked for
constexpr int kCoarseCells = 72;
constexpr int kOutlineSide = 400;  // pixels
constexpr int kNormalRadius = 3;   // cells

Bounds3 box_of_points(const ViewSet& set) {
  Bounds3 box{{-1, -1, -1}, {1, 1, 1}};
  if (set.points.empty()) return box;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const ScenePoint& p : set.points) values.push_back(p.position[c]);
    const double low = quantile_of(values, kPercentile), high = quantile_of(values, 1 - kPercentile);
    box.low[c] = low - kMargin * (high - low);
    box.high[c] = high + kMargin * (high - low);
  }
  return box;
}

MaskClass mask_class(HullClass kind) { return kind == HullClass::Glass ? MaskClass::Transparent : MaskClass::Specular; }

HullOpinion opinion(const MaskHullDesc& desc, uint32_t photo, size_t level) {
  const auto& masks = desc.targets.photos[photo][level].masks;
  const auto& transparent = masks[size_t(MaskClass::Transparent)];
  if (desc.kind == HullClass::Glass) return {transparent, {}};
  return {masks[size_t(MaskClass::Specular)], transparent};
}

bool inside_hull(const std::vector<HullJudge>& judges, const Vec3d& p) {
  int seen = 0, inside = 0, outside = 0;
  for (const HullJudge& judge : judges) {
    const auto q = image_point(p, *judge.view);
    if (!q) continue;
    const size_t pixel = size_t(q->y) * size_t(judge.view->intrinsics.width) + size_t(q->x);
    if (!judge.says.other.empty() && judge.says.other[pixel] >= 128) continue;
    ++seen;
    if (judge.says.mask[pixel] >= 128)
      ++inside;
    else if (!(judge.depth[pixel] > 0 && judge.depth[pixel] < kHullInFront * float(q->z)))
      ++outside;
  }
  return inside >= kHullFewestPhotos && inside >= kHullSeenShare * double(judges.size()) && inside >= kHullInsideShare * seen &&
         outside <= kHullOutsideShare * (inside + outside);
}

VoxelGrid<uint8_t> carved(const std::vector<HullJudge>& judges, const Bounds3& box, int cells) {
  const Vec3d extent = box.high - box.low;
  VoxelGrid<uint8_t> grid;
  grid.cell = std::max({extent.x, extent.y, extent.z}) / cells;
  grid.origin = box.low;
  for (size_t c = 0; c < 3; ++c) grid.size[c] = std::max(1, int(std::ceil(extent[c] / grid.cell)));
  grid.values.assign(grid.count(), 0);
  grid.each([&](int x, int y, int z) { grid.values[grid.index(x, y, z)] = inside_hull(judges, grid.centre(x, y, z)); });
  return grid;
}

// Around what is inside, a few cells wider.
bool tighten(const VoxelGrid<uint8_t>& grid, Bounds3& box) {
  std::array<int, 3> low = grid.size, high{-1, -1, -1};
  grid.each_in_order([&](int x, int y, int z) {
    if (!grid.at(x, y, z)) return;
    const std::array<int, 3> at{x, y, z};
    for (size_t c = 0; c < 3; ++c) low[c] = std::min(low[c], at[c]), high[c] = std::max(high[c], at[c]);
  });
  if (high[0] < 0) return false;
  constexpr int kPadding = 2;
  for (size_t c = 0; c < 3; ++c) {
    box.low[c] = grid.origin[c] + grid.cell * (low[c] - kPadding);
    box.high[c] = grid.origin[c] + grid.cell * (high[c] + 1 + kPadding);
  }
  return true;
}

// From occupied cells to empty ones, around (x, y, z); zero where they balance.
Vec3d outward(const VoxelGrid<uint8_t>& grid, int x, int y, int z) {
  Vec3d sum{};
  for (int k = -kNormalRadius; k <= kNormalRadius; ++k)
    for (int j = -kNormalRadius; j <= kNormalRadius; ++j)
      for (int i = -kNormalRadius; i <= kNormalRadius; ++i)
        if (grid.at(x + i, y + j, z + k)) sum += Vec3d{double(-i), double(-j), double(-k)};
  return sum;
}

// Outlines tell a place to a fraction of a pixel: small masks will do, and large ones of all photos fill memory.
std::vector<HullMask> outlines(const MaskHullDesc& desc) {
  std::vector<HullMask> masks;
  for (uint32_t photo : desc.capture.train) {
    const auto& levels = desc.capture.photos[photo].levels;
    size_t level = desc.level;
    while (level + 1 < kLevels && levels[level].view.intrinsics.longest_side() > kOutlineSide) ++level;
    const HullOpinion says = opinion(desc, photo, level);
    if (says.mask.empty()) continue;
    const View& view = levels[level].view;
    masks.push_back({view, ImageF(view.intrinsics.width, view.intrinsics.height, 1)});
    std::span<float> said = masks.back().mask.data();
    for (size_t i = 0; i < said.size(); ++i)
      said[i] = !says.other.empty() && says.other[i] >= 128 ? -1.f : float(says.mask[i]) / 255.f;
  }
  return masks;
}

// A grid of points over every face.
void put_on(const Box& box, double spacing, std::vector<HullPoint>& points) {
  for (size_t axis = 0; axis < 3; ++axis)
    for (bool upper : {false, true}) {
      const size_t u = (axis + 1) % 3, v = (axis + 2) % 3;
      const auto steps = [&](size_t along) { return std::max(1, int((box.high[along] - box.low[along]) / spacing)); };
      Vec3d outwards{};
      outwards[axis] = upper ? 1 : -1;
      for (int i = 0; i < steps(u); ++i)
        for (int j = 0; j < steps(v); ++j) {
          Vec3d p;
          p[axis] = (upper ? box.high : box.low)[axis];
          p[u] = box.low[u] + (i + 0.5) / steps(u) * (box.high[u] - box.low[u]);
          p[v] = box.low[v] + (j + 0.5) / steps(v) * (box.high[v] - box.low[v]);
          points.push_back({cast<float>(box.axes * p), cast<float>(box.axes * outwards), true});
        }
    }
}

}  // namespace

Hull mask_hull(const MaskHullDesc& desc) {
  std::vector<HullJudge> judges;
  for (uint32_t photo : desc.capture.train) {
    const HullOpinion says = opinion(desc, photo, desc.level);
    if (!says.mask.empty()) judges.push_back({&desc.capture.photos[photo].levels[desc.level].view, says, desc.depths[photo]});
  }
  Hull hull;
  Bounds3 box = box_of_points(desc.capture.view_set);
  if (judges.empty() || !tighten(carved(judges, box, kCoarseCells), box)) return hull;
  const VoxelGrid<uint8_t> grid = carved(judges, box, desc.cells);
  hull.spacing = float(grid.cell);
  std::vector<HullSurfacePoint> surface;
  grid.each_in_order([&](int x, int y, int z) {
    if (!grid.at(x, y, z)) return;
    if (grid.at(x - 1, y, z) && grid.at(x + 1, y, z) && grid.at(x, y - 1, z) && grid.at(x, y + 1, z) && grid.at(x, y, z - 1) &&
        grid.at(x, y, z + 1))
      return;
    const Vec3d n = outward(grid, x, y, z);
    if (length(n) > 0) surface.push_back({grid.centre(x, y, z), normalized(n)});
  });
  const std::vector<HullMask> masks = outlines(desc);
  Bounds3 bounds;
  for (const HullSurfacePoint& p : surface) bounds.extend(p.position);
  const char* what = desc.kind == HullClass::Glass ? "glass" : "gloss";
  if (const std::optional<BoxFit> fit = fit_box(masks, bounds)) {
    log_info("the {} is a box ({:.0f} % of the masks and of its outlines agree)", what, 100 * fit->agreement);
    put_on(fit->box, grid.cell, hull.points);
    hull.box = fit->box;
    return hull;
  }
  hull.solids = solids_of_revolution(masks, surface, grid.cell);
  if (!hull.solids.empty())
    log_info("the {} has {} solid{} of revolution", what, hull.solids.size(), hull.solids.size() > 1 ? "s" : "");
  std::vector<FlatFace> faces;
  if (hull.solids.empty()) faces = flat_faces(surface, grid.cell);  // which finds facets on round things as well
  const HullThings things = hull_things(grid, surface, hull.solids);
  add_things(things, judges, desc.targets.carried[size_t(mask_class(desc.kind))], hull);
  for (HullSurfacePoint p : surface) {
    if (things.of.at(p.position) <= things.with_solids) continue;  // has a finer one
    const std::optional<HullSurfacePoint> on = on_solid(hull.solids, p, grid.cell);
    if (on) p = *on;
    if (const FlatFace* face = face_of(faces, p, grid.cell))
      p = {p.position + (face->offset - dot(face->normal, p.position)) * face->normal, face->normal};
    hull.points.push_back({cast<float>(p.position), cast<float>(p.normal), on.has_value()});
  }
  return hull;
}

}  // namespace vitrine
