#include "stages/optimize/hull.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/log.h"
#include "core/base/parallel.h"
#include "core/stereo/box_fit.h"
#include "core/stereo/flat_faces.h"

namespace vitrine {

namespace {

constexpr double kPercentile = 0.02, kMargin = 0.2;  // of the sparse points: where things are looked for
constexpr double kInsideShare = 0.6;                 // of the photos that see a point: fewer is chance
// Of those with an opinion, that a point may contradict: masks have errors, and panes have frames. More lets the hull bulge.
constexpr double kOutsideShare = 0.08;
// Of all photos with a mask, that see a point inside it: what few look at is contradicted by nobody.
constexpr double kSeenShare = 0.3;
constexpr int kFewestPhotos = 3;
constexpr float kInFront = 0.97f;  // a surface nearer than this part of a point's depth hides it
constexpr int kCoarseCells = 72;
constexpr int kNormalRadius = 3;  // cells

struct Box {
  Vec3d low, high;
};

struct Grid {
  Vec3d origin;
  double cell;
  std::array<int, 3> size;
  std::vector<uint8_t> inside;
  size_t index(int x, int y, int z) const { return (size_t(z) * size_t(size[1]) + size_t(y)) * size_t(size[0]) + size_t(x); }
  bool at(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2] && inside[index(x, y, z)] != 0;
  }
  Vec3d centre(int x, int y, int z) const { return origin + cell * Vec3d{x + 0.5, y + 0.5, z + 0.5}; }
};

Box box_of_points(const ViewSet& set) {
  Box box{{-1, -1, -1}, {1, 1, 1}};
  if (set.points.empty()) return box;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<double> values;
    for (const ScenePoint& p : set.points) values.push_back(p.position[c]);
    std::sort(values.begin(), values.end());
    const double low = values[size_t(kPercentile * double(values.size() - 1))];
    const double high = values[size_t((1 - kPercentile) * double(values.size() - 1))];
    box.low[c] = low - kMargin * (high - low);
    box.high[c] = high + kMargin * (high - low);
  }
  return box;
}

struct Judge {
  const View* view;
  std::span<const uint8_t> mask, other;  // empty: nowhere
  std::span<const float> depth;
};

bool inside_hull(const std::vector<Judge>& judges, const Vec3d& p) {
  int seen = 0, inside = 0, outside = 0;
  for (const Judge& judge : judges) {
    const Intrinsics& k = judge.view->intrinsics;
    const Vec3d q = judge.view->cam_from_world * p;
    if (q.z <= 0) continue;
    const double x = k.fx * q.x / q.z + k.cx, y = k.fy * q.y / q.z + k.cy;
    if (!(x >= 0 && y >= 0 && x < k.width && y < k.height)) continue;
    const size_t pixel = size_t(y) * size_t(k.width) + size_t(x);
    if (!judge.other.empty() && judge.other[pixel] >= 128) continue;
    ++seen;
    if (judge.mask[pixel] >= 128)
      ++inside;
    else if (!(judge.depth[pixel] > 0 && judge.depth[pixel] < kInFront * float(q.z)))
      ++outside;
  }
  return inside >= kFewestPhotos && inside >= kSeenShare * double(judges.size()) && inside >= kInsideShare * seen &&
         outside <= kOutsideShare * (inside + outside);
}

Grid carved(const std::vector<Judge>& judges, const Box& box, int cells) {
  const Vec3d extent = box.high - box.low;
  Grid grid;
  grid.cell = std::max({extent.x, extent.y, extent.z}) / cells;
  grid.origin = box.low;
  for (size_t c = 0; c < 3; ++c) grid.size[c] = std::max(1, int(std::ceil(extent[c] / grid.cell)));
  grid.inside.assign(size_t(grid.size[0]) * size_t(grid.size[1]) * size_t(grid.size[2]), 0);
  parallel_for(size_t(grid.size[2]), 1, [&](size_t z) {
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x)
        grid.inside[grid.index(x, y, int(z))] = inside_hull(judges, grid.centre(x, y, int(z)));
  });
  return grid;
}

// Around what is inside, a few cells wider.
bool tighten(const Grid& grid, Box& box) {
  std::array<int, 3> low = grid.size, high{-1, -1, -1};
  for (int z = 0; z < grid.size[2]; ++z)
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x) {
        if (!grid.at(x, y, z)) continue;
        const std::array<int, 3> at{x, y, z};
        for (size_t c = 0; c < 3; ++c) {
          low[c] = std::min(low[c], at[c]);
          high[c] = std::max(high[c], at[c]);
        }
      }
  if (high[0] < 0) return false;
  constexpr int kPadding = 2;
  for (size_t c = 0; c < 3; ++c) {
    box.low[c] = grid.origin[c] + grid.cell * (low[c] - kPadding);
    box.high[c] = grid.origin[c] + grid.cell * (high[c] + 1 + kPadding);
  }
  return true;
}

// From occupied cells to empty ones, around (x, y, z); zero where they balance.
Vec3d outward(const Grid& grid, int x, int y, int z) {
  Vec3d sum{};
  for (int k = -kNormalRadius; k <= kNormalRadius; ++k)
    for (int j = -kNormalRadius; j <= kNormalRadius; ++j)
      for (int i = -kNormalRadius; i <= kNormalRadius; ++i)
        if (grid.at(x + i, y + j, z + k)) sum += Vec3d{double(-i), double(-j), double(-k)};
  return sum;
}

std::optional<BoxFit> box_of(const std::vector<Judge>& judges, std::span<const HullSurfacePoint> surface) {
  std::vector<HullMask> masks;
  for (const Judge& judge : judges) {
    const Intrinsics& k = judge.view->intrinsics;
    masks.push_back({*judge.view, ImageF(k.width, k.height, 1)});
    std::span<float> said = masks.back().mask.data();
    for (size_t i = 0; i < said.size(); ++i)
      said[i] = !judge.other.empty() && judge.other[i] >= 128 ? -1.f : float(judge.mask[i]) / 255.f;
  }
  Bounds3 bounds;
  for (const HullSurfacePoint& p : surface) bounds.extend(p.position);
  return fit_box(masks, bounds);
}

// A grid of points over every face.
void put_on(const OrientedBox& box, double spacing, std::vector<HullPoint>& points) {
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
          points.push_back({cast<float>(box.axes * p), cast<float>(box.axes * outwards)});
        }
    }
}

}  // namespace

Hull mask_hull(const MaskHullDesc& desc) {
  std::vector<Judge> judges;
  for (uint32_t photo : desc.capture.train) {
    const auto& masks = desc.targets.photos[photo][desc.level].masks;
    const bool glass = desc.kind == HullClass::Glass;
    const auto& transparent = masks[size_t(MaskClass::Transparent)];
    const auto& mask = glass ? transparent : masks[size_t(MaskClass::Specular)];
    if (mask.empty()) continue;
    judges.push_back({&desc.capture.photos[photo].levels[desc.level].view, mask,
                      glass ? std::span<const uint8_t>() : std::span<const uint8_t>(transparent), desc.depths[photo]});
  }
  Hull hull;
  Box box = box_of_points(desc.capture.view_set);
  if (judges.empty() || !tighten(carved(judges, box, kCoarseCells), box)) return hull;
  const Grid grid = carved(judges, box, desc.cells);
  hull.spacing = float(grid.cell);
  std::vector<HullSurfacePoint> surface;
  for (int z = 0; z < grid.size[2]; ++z)
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x) {
        if (!grid.at(x, y, z)) continue;
        if (grid.at(x - 1, y, z) && grid.at(x + 1, y, z) && grid.at(x, y - 1, z) && grid.at(x, y + 1, z) &&
            grid.at(x, y, z - 1) && grid.at(x, y, z + 1))
          continue;
        const Vec3d n = outward(grid, x, y, z);
        if (!(length(n) > 0)) continue;
        surface.push_back({grid.centre(x, y, z), normalized(n)});
      }
  if (const std::optional<BoxFit> fit = box_of(judges, surface)) {
    log_info("the {} is a box ({:.0f} % of the masks and of its outlines agree)",
             desc.kind == HullClass::Glass ? "glass" : "gloss", 100 * fit->agreement);
    put_on(fit->box, grid.cell, hull.points);
    return hull;
  }
  const std::vector<FlatFace> faces = flat_faces(surface, grid.cell);
  for (HullSurfacePoint p : surface) {
    if (const FlatFace* face = face_of(faces, p, grid.cell))
      p = {p.position + (face->offset - dot(face->normal, p.position)) * face->normal, face->normal};
    hull.points.push_back({cast<float>(p.position), cast<float>(p.normal)});
  }
  return hull;
}

}  // namespace vitrine
