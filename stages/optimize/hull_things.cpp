#include "stages/optimize/hull_things.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/mesh/clean_openmesh.h"
#include "core/mesh/mesh_topology.h"
#include "stages/optimize/fine_hull.h"

namespace vitrine {

namespace {

constexpr int kFineCells = 160;          // along the longest side of a thing
constexpr int kNearSurface = 2;          // cells of the hull: the fine surface lies within
constexpr size_t kMostFaces = 8000;      // of what stands out
constexpr double kSunk = 1, kBulge = 2;  // of its cells, above the solid: what is lower is inside; a hull bulges so far
constexpr double kLikeTheSolid = 0.8;    // cosine of normals of what bulges
constexpr double kFarOut_rel = 0.3;      // of the largest radius: how far something stands out, at least
constexpr double kRootWay = 1.25;        // times as far as straight from there to the solid: on the way
constexpr double kHugs_rel = 0.15;       // of the largest radius: what is lower, and not on the way, is the solid
constexpr double kThinning = 2;          // of the fine cells
constexpr double kCrowd = 6;  // of its other parts, necks and handles, which bend faster than the solid: points in place of one

// Of a cell: the thing it is of or, near the surface of things, the nearest one.
struct NearestThing {
  uint32_t thing = 0;
  bool near_surface = false;
};
VoxelGrid<NearestThing> nearest_things(const VoxelGrid<uint32_t>& of) {
  VoxelGrid<NearestThing> out{of.origin, of.cell, of.size, std::vector<NearestThing>(of.values.size())};
  of.each([&](int x, int y, int z) {
    const uint32_t own = of.at(x, y, z);
    NearestThing& found = out.values[of.index(x, y, z)];
    found.thing = own;
    int distance = own != 0 ? 0 : INT32_MAX;
    for (int k = -kNearSurface; k <= kNearSurface; ++k)
      for (int j = -kNearSurface; j <= kNearSurface; ++j)
        for (int i = -kNearSurface; i <= kNearSurface; ++i) {
          const uint32_t other = of.at(x + i, y + j, z + k);
          found.near_surface |= other != own;
          if (const int d = i * i + j * j + k * k; other != 0 && d < distance) distance = d, found.thing = other;
        }
  });
  return out;
}

void append(TriMesh& to, const TriMesh& more) {
  const auto first = static_cast<uint32_t>(to.positions.size());
  to.positions.insert(to.positions.end(), more.positions.begin(), more.positions.end());
  for (const auto& f : more.faces) to.faces.push_back({first + f[0], first + f[1], first + f[2]});
}

// What stands out of the solids, up to its root. Masks that were carried from few marks have too much beside an appendage: of
// theirs only what is far out counts, and what lies on its way to the solid.
class StandingOut {
 public:
  // `mesh`: with normals.
  StandingOut(const TriMesh& mesh, std::span<const SolidOfRevolution> solids, double cell, bool carried)
      : solids_(solids), cell_(cell), carried_(carried) {
    if (!carried) return;
    std::vector<Above> above(mesh.positions.size());
    parallel_for(above.size(), 256, [&](size_t v) { above[v] = nearest(cast<double>(mesh.positions[v])); });
    std::set<std::array<int, 3>> taken;  // cubes of kThinning cells: one of each is enough
    for (size_t v = 0; v < above.size(); ++v) {
      const Vec3d p = cast<double>(mesh.positions[v]), q = p / (kThinning * cell);
      if (above[v].far && taken.insert({int(std::floor(q.x)), int(std::floor(q.y)), int(std::floor(q.z))}).second)
        far_.push_back({p, above[v].height});
    }
  }
  bool operator()(const Vec3d& p, const Vec3d& normal) const {
    for (const SolidOfRevolution& solid : solids_) {
      const HullSurfacePoint on = solid.nearest(p);
      const double height = dot(p - on.position, on.normal);
      if (height < kSunk * cell_ || (height < kBulge * cell_ && dot(on.normal, normal) > kLikeTheSolid)) return false;
    }
    if (!carried_) return true;
    const Above above = nearest(p);
    return above.far || on_the_way(p, above.height);
  }
  // What bulges off a solid is the solid.
  std::optional<HullSurfacePoint> bulges_off(const Vec3d& p) const {
    const Above above = nearest(p);
    if (!carried_ || above.height > kHugs_rel * above.radius || on_the_way(p, above.height)) return std::nullopt;
    return above.on;
  }
  bool is_far(const Vec3d& p) const { return nearest(p).far; }

 private:
  struct Above {
    double height = 1e300, radius = 0;
    HullSurfacePoint on;
    bool far = true;  // of all solids
  };
  struct Far {
    Vec3d place;
    double height;
  };
  Above nearest(const Vec3d& p) const {
    Above out;
    for (const SolidOfRevolution& solid : solids_) {
      const HullSurfacePoint on = solid.nearest(p);
      const double height = dot(p - on.position, on.normal), radius = std::ranges::max(solid.radii);
      const bool far = out.far && height > kFarOut_rel * radius;
      if (height < out.height) out = {height, radius, on};
      out.far = far;
    }
    return out;
  }
  bool on_the_way(const Vec3d& p, double height) const {
    const Far* best = nullptr;
    double distance = 1e300;
    for (const Far& far : far_)
      if (const double d = length(far.place - p); d < distance) distance = d, best = &far;
    return best && distance + height <= kRootWay * best->height + kThinning * cell_;
  }

  const std::span<const SolidOfRevolution> solids_;
  const double cell_;
  const bool carried_;
  std::vector<Far> far_;
};

// Pieces that reach far out. A hull bulges under a foot and above a lid, where no outline says otherwise.
TriMesh far_out(const TriMesh& mesh, const StandingOut& stands_out) {
  const FaceComponents pieces = face_components(mesh);
  std::vector<uint8_t> far(pieces.faces.size(), 0), keep(mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (size_t c = 0; c < 3 && !far[pieces.label[f]]; ++c)
      far[pieces.label[f]] = stands_out.is_far(cast<double>(mesh.positions[mesh.faces[f][c]]));
  for (size_t f = 0; f < keep.size(); ++f) keep[f] = far[pieces.label[f]];
  return submesh(mesh, keep);
}

// As far as photos look at it.
TriMesh beside(TriMesh mesh, const std::vector<HullJudge>& judges, const StandingOut& stands_out) {
  std::vector<uint8_t> out(mesh.positions.size(), 0), keep(mesh.faces.size());
  parallel_for(out.size(), 256, [&](size_t v) {
    const Vec3d p = cast<double>(mesh.positions[v]), n = cast<double>(mesh.normals[v]);
    int facing = 0;
    for (const HullJudge& judge : judges) facing += dot(n, judge.view->centre_in_world() - p) > 0;
    out[v] = facing >= kHullFewestPhotos && stands_out(p, n);
  });
  for (size_t f = 0; f < keep.size(); ++f)
    for (uint32_t v : mesh.faces[f]) keep[f] |= out[v];
  const TriMesh standing = far_out(submesh(mesh, keep), stands_out);
  return standing.faces.size() > kMostFaces ? decimated(standing, {.target_faces = kMostFaces}) : standing;
}

// The surface of one thing: on the solid as many points as the coarse grid has, elsewhere kCrowd times as many. Returns what
// stands out of the solids.
TriMesh add_fine(uint32_t thing, const Bounds3& bounds, const VoxelGrid<NearestThing>& nearest,
                 const std::vector<HullJudge>& judges, std::span<const SolidOfRevolution> solids, bool carried,
                 std::vector<HullPoint>& points) {
  const double coarse = nearest.cell;
  const Vec3d extent = bounds.high - bounds.low;
  const double cell = std::min(coarse, std::max({extent.x, extent.y, extent.z, coarse}) / kFineCells);
  const double share = (cell / coarse) * (cell / coarse);
  double on_due = 0, off_due = 0;
  FineHull fine = fine_hull(judges, bounds, cell, [&](const Vec3d& p) {
    const NearestThing at = nearest.at(p);
    return at.thing != thing ? 0 : at.near_surface ? -1 : 1;
  });
  fine.mesh.normals = vertex_normals(fine.mesh);
  const StandingOut stands_out(fine.mesh, solids, cell, carried);
  for (HullSurfacePoint p : fine.points) {
    std::optional<HullSurfacePoint> on = on_solid(solids, p, 2 * cell);
    if (on && length(on->position - p.position) > kBulge * cell && dot(on->normal, p.normal) < kLikeTheSolid) on.reset();
    if (!on) on = stands_out.bulges_off(p.position);
    double& due = on ? on_due : off_due;
    due += on ? share : std::min(1.0, kCrowd * share);
    if (due < 1) continue;
    due -= 1;
    if (on) p = *on;
    points.push_back({cast<float>(p.position), cast<float>(p.normal), true,
                      on ? 1.f : static_cast<float>(std::sqrt(share / std::min(1.0, kCrowd * share)))});
  }
  return beside(std::move(fine.mesh), judges, stands_out);
}

}  // namespace

HullThings hull_things(const VoxelGrid<uint8_t>& inside, std::span<const HullSurfacePoint> surface,
                       std::span<const SolidOfRevolution> solids) {
  HullThings out;
  out.of = {inside.origin, inside.cell, inside.size, std::vector<uint32_t>(inside.values.size(), 0)};
  const ConnectedComponents parts = connected_components(inside, [&](size_t i) { return inside.values[i] != 0; });
  std::vector<uint32_t> thing(parts.members.size(), 0);
  uint32_t things = 0;
  for (const SolidOfRevolution& solid : solids) {
    bool begins = false;
    for (const HullSurfacePoint& p : surface) {
      if (!solid.smoothed(p, inside.cell)) continue;
      const auto [x, y, z] = inside.cell_of(p.position);
      if (!inside.at(x, y, z)) continue;
      uint32_t& of_part = thing[parts.label[inside.index(x, y, z)]];
      if (of_part == 0) of_part = things + 1, begins = true;
    }
    things += begins;
  }
  out.with_solids = things;
  for (uint32_t& of_part : thing)
    if (of_part == 0) of_part = ++things;
  for (size_t i = 0; i < out.of.values.size(); ++i)
    if (inside.values[i]) out.of.values[i] = thing[parts.label[i]];
  return out;
}

void add_things(const HullThings& things, const std::vector<HullJudge>& judges, bool carried, Hull& hull) {
  const VoxelGrid<uint32_t>& of = things.of;
  std::vector<Bounds3> bounds(things.with_solids);
  of.each_in_order([&](int x, int y, int z) {
    if (const uint32_t thing = of.at(x, y, z); thing != 0 && thing <= bounds.size()) bounds[thing - 1].extend(of.centre(x, y, z));
  });
  if (bounds.empty()) return;
  const VoxelGrid<NearestThing> nearest = nearest_things(of);
  for (uint32_t k = 0; k < bounds.size(); ++k)
    append(hull.beside, add_fine(k + 1, bounds[k], nearest, judges, hull.solids, carried, hull.points));
}

}  // namespace vitrine
