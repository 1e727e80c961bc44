#include "stages/optimize/hull.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/log.h"
#include "core/base/parallel.h"
#include "core/mesh/clean_openmesh.h"
#include "core/mesh/mesh_topology.h"
#include "core/stereo/box_fit.h"
#include "core/stereo/flat_faces.h"
#include "core/stereo/revolution_fit.h"
#include "stages/optimize/fine_hull.h"

namespace vitrine {

namespace {

constexpr double kPercentile = 0.02, kMargin = 0.2;  // of the sparse points: where things are looked for
constexpr int kCoarseCells = 72;
constexpr int kOutlineSide = 400;        // pixels
constexpr int kNormalRadius = 3;         // cells
constexpr int kFineCells = 160;          // along the longest side of a thing that is a solid of revolution in part
constexpr int kNearSurface = 2;          // cells of the hull: the fine surface lies within
constexpr size_t kMostFaces = 8000;      // of what stands out
constexpr double kSunk = 1, kBulge = 2;  // of its cells, above the solid: what is lower is inside; a hull bulges so far
constexpr double kLikeTheSolid = 0.8;    // cosine of normals of what bulges
constexpr double kFarOut_rel = 0.3;      // of the largest radius: how far a piece stands out, at least
constexpr double kCrowd = 6;  // of its other parts, spouts and handles, which bend faster than the solid: points in place of one

struct Grid {
  Vec3d origin;
  double cell;
  std::array<int, 3> size;
  std::vector<uint8_t> inside;
  size_t index(int x, int y, int z) const { return (size_t(z) * size_t(size[1]) + size_t(y)) * size_t(size[0]) + size_t(x); }
  bool at(int x, int y, int z) const {
    return x >= 0 && y >= 0 && z >= 0 && x < size[0] && y < size[1] && z < size[2] && inside[index(x, y, z)] != 0;
  }
  std::array<int, 3> cell_of(const Vec3d& p) const {
    const Vec3d q = (p - origin) / cell;
    return {int(std::floor(q.x)), int(std::floor(q.y)), int(std::floor(q.z))};
  }
  Vec3d centre(int x, int y, int z) const { return origin + cell * Vec3d{x + 0.5, y + 0.5, z + 0.5}; }
};

Bounds3 box_of_points(const ViewSet& set) {
  Bounds3 box{{-1, -1, -1}, {1, 1, 1}};
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

HullOpinion opinion(const MaskHullDesc& desc, uint32_t photo, size_t level) {
  const auto& masks = desc.targets.photos[photo][level].masks;
  const auto& transparent = masks[size_t(MaskClass::Transparent)];
  if (desc.kind == HullClass::Glass) return {transparent, {}};
  return {masks[size_t(MaskClass::Specular)], transparent};
}

bool inside_hull(const std::vector<HullJudge>& judges, const Vec3d& p) {
  int seen = 0, inside = 0, outside = 0;
  for (const HullJudge& judge : judges) {
    const Intrinsics& k = judge.view->intrinsics;
    const Vec3d q = judge.view->cam_from_world * p;
    if (q.z <= 0) continue;
    const double x = k.fx * q.x / q.z + k.cx, y = k.fy * q.y / q.z + k.cy;
    if (!(x >= 0 && y >= 0 && x < k.width && y < k.height)) continue;
    const size_t pixel = size_t(y) * size_t(k.width) + size_t(x);
    if (!judge.says.other.empty() && judge.says.other[pixel] >= 128) continue;
    ++seen;
    if (judge.says.mask[pixel] >= 128)
      ++inside;
    else if (!(judge.depth[pixel] > 0 && judge.depth[pixel] < kHullInFront * float(q.z)))
      ++outside;
  }
  return inside >= kHullFewestPhotos && inside >= kHullSeenShare * double(judges.size()) && inside >= kHullInsideShare * seen &&
         outside <= kHullOutsideShare * (inside + outside);
}

Grid carved(const std::vector<HullJudge>& judges, const Bounds3& box, int cells) {
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
bool tighten(const Grid& grid, Bounds3& box) {
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

// The cells of the hull that hang together with those around `seeds`, by number of the thing; 0: of none of them.
std::vector<uint32_t> things(const Grid& grid, const std::vector<HullSurfacePoint>& surface,
                             const std::vector<std::vector<size_t>>& seeds) {
  std::vector<uint32_t> thing(grid.inside.size(), 0);
  for (uint32_t k = 0; k < seeds.size(); ++k) {
    std::vector<std::array<int, 3>> open;
    const auto take = [&](int x, int y, int z) {
      if (!grid.at(x, y, z) || thing[grid.index(x, y, z)] != 0) return;
      thing[grid.index(x, y, z)] = k + 1;
      open.push_back({x, y, z});
    };
    for (size_t i : seeds[k]) {
      const std::array<int, 3> at = grid.cell_of(surface[i].position);
      take(at[0], at[1], at[2]);
    }
    while (!open.empty()) {
      const auto [x, y, z] = open.back();
      open.pop_back();
      for (int d : {-1, 1}) take(x + d, y, z), take(x, y + d, z), take(x, y, z + d);
    }
  }
  return thing;
}

// Cells within kNearSurface of the surface.
std::vector<uint8_t> near_surface(const Grid& grid) {
  std::vector<uint8_t> near(grid.inside.size(), 0);
  parallel_for(size_t(grid.size[2]), 1, [&](size_t z) {
    for (int y = 0; y < grid.size[1]; ++y)
      for (int x = 0; x < grid.size[0]; ++x) {
        const bool own = grid.at(x, y, int(z));
        uint8_t& flag = near[grid.index(x, y, int(z))];
        for (int k = -kNearSurface; k <= kNearSurface && !flag; ++k)
          for (int j = -kNearSurface; j <= kNearSurface && !flag; ++j)
            for (int i = -kNearSurface; i <= kNearSurface && !flag; ++i) flag = grid.at(x + i, y + j, int(z) + k) != own;
      }
  });
  return near;
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
          points.push_back({cast<float>(box.axes * p), cast<float>(box.axes * outwards), true});
        }
    }
}

void append(TriMesh& to, const TriMesh& more) {
  const auto first = static_cast<uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
  for (const auto& f : more.faces) to.faces.push_back({first + f[0], first + f[1], first + f[2]});
}

// Pieces that reach far out of the solids. A hull bulges under a foot and above a lid, where no outline says otherwise.
TriMesh far_out(const TriMesh& mesh, std::span<const SolidOfRevolution> solids) {
  const FaceComponents pieces = face_components(mesh);
  std::vector<uint8_t> far(pieces.faces.size(), 0), keep(mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (size_t c = 0; c < 3 && !far[pieces.label[f]]; ++c) {
      const Vec3d p = cast<double>(mesh.positions[mesh.faces[f][c]]);
      bool beyond = true;
      for (const SolidOfRevolution& solid : solids) {
        const HullSurfacePoint on = solid.nearest(p);
        beyond &= dot(p - on.position, on.normal) > kFarOut_rel * std::ranges::max(solid.radii);
      }
      far[pieces.label[f]] = beyond;
    }
  for (size_t f = 0; f < keep.size(); ++f) keep[f] = far[pieces.label[f]];
  return submesh(mesh, keep);
}

// What stands out of the solids, as far as photos look at it: a hull bulges around them by some cells, with their normals.
TriMesh beside(TriMesh mesh, const std::vector<HullJudge>& judges, std::span<const SolidOfRevolution> solids, double cell) {
  mesh.normals = vertex_normals(mesh);
  std::vector<uint8_t> out(mesh.positions.size(), 1), keep(mesh.faces.size());
  parallel_for(out.size(), 256, [&](size_t v) {
    const Vec3d p = cast<double>(mesh.positions[v]), n = cast<double>(mesh.normals[v]);
    int facing = 0;
    for (const HullJudge& judge : judges) facing += dot(n, judge.view->centre_in_world() - p) > 0;
    if (facing < kHullFewestPhotos) out[v] = 0;
    for (const SolidOfRevolution& solid : solids) {
      const HullSurfacePoint on = solid.nearest(p);
      const double above = dot(p - on.position, on.normal);
      if (above < kSunk * cell || (above < kBulge * cell && dot(on.normal, n) > kLikeTheSolid)) out[v] = 0;
    }
  });
  for (size_t f = 0; f < keep.size(); ++f)
    for (uint32_t v : mesh.faces[f]) keep[f] |= out[v];
  const TriMesh standing = far_out(submesh(mesh, keep), solids);
  return standing.faces.size() > kMostFaces ? decimated(standing, {.target_faces = kMostFaces}) : standing;
}

// The surface of one thing: on the solid as many points as the coarse grid has, elsewhere kCrowd times as many. Returns what
// stands out of the solids.
TriMesh add_fine(const std::vector<HullJudge>& judges, const Bounds3& bounds, std::span<const SolidOfRevolution> solids,
                 const Grid& grid, const std::vector<uint8_t>& near, std::vector<HullPoint>& points) {
  const double coarse = grid.cell;
  const Vec3d extent = bounds.high - bounds.low;
  const double cell = std::min(coarse, std::max({extent.x, extent.y, extent.z}) / kFineCells);
  const double share = (cell / coarse) * (cell / coarse);
  double on_due = 0, off_due = 0;
  FineHull fine = fine_hull(judges, bounds, cell, [&](const Vec3d& p) {
    const auto at = grid.cell_of(p);
    for (size_t c = 0; c < 3; ++c)
      if (at[c] < 0 || at[c] >= grid.size[c]) return 0;
    const size_t i = grid.index(at[0], at[1], at[2]);
    return near[i] ? -1 : int(grid.inside[i]);
  });
  for (HullSurfacePoint p : fine.points) {
    std::optional<HullSurfacePoint> on = on_solid(solids, p, 2 * cell);
    if (on && length(on->position - p.position) > kBulge * cell && dot(on->normal, p.normal) < kLikeTheSolid) on.reset();
    double& due = on ? on_due : off_due;
    due += on ? share : std::min(1.0, kCrowd * share);
    if (due < 1) continue;
    due -= 1;
    if (on) p = *on;
    points.push_back({cast<float>(p.position), cast<float>(p.normal), true,
                      on ? 1.f : static_cast<float>(std::sqrt(share / std::min(1.0, kCrowd * share)))});
  }
  return beside(std::move(fine.mesh), judges, solids, cell);
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
  // Things with a solid have a surface of their own, finer than the hull's cells.
  std::vector<std::vector<size_t>> seeds(hull.solids.size());
  for (size_t i = 0; i < surface.size(); ++i)
    for (size_t k = 0; k < hull.solids.size(); ++k)
      if (hull.solids[k].smoothed(surface[i], grid.cell)) seeds[k].push_back(i);
  const std::vector<uint32_t> thing_of = things(grid, surface, seeds);
  std::vector<Bounds3> fine(seeds.size());
  for (const HullSurfacePoint& p : surface) {
    const auto at = grid.cell_of(p.position);
    if (const uint32_t thing = thing_of[grid.index(at[0], at[1], at[2])]; thing != 0) fine[thing - 1].extend(p.position);
  }
  const std::vector<uint8_t> near = near_surface(grid);
  for (const Bounds3& bounds : fine)
    if (!bounds.empty()) append(hull.beside, add_fine(judges, bounds, hull.solids, grid, near, hull.points));
  for (HullSurfacePoint p : surface) {
    const auto at = grid.cell_of(p.position);
    if (thing_of[grid.index(at[0], at[1], at[2])] != 0) continue;
    const std::optional<HullSurfacePoint> on = on_solid(hull.solids, p, grid.cell);
    if (on) p = *on;
    if (const FlatFace* face = face_of(faces, p, grid.cell))
      p = {p.position + (face->offset - dot(face->normal, p.position)) * face->normal, face->normal};
    hull.points.push_back({cast<float>(p.position), cast<float>(p.normal), on.has_value()});
  }
  return hull;
}

}  // namespace vitrine
