#include "stages/objects/detect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_topology.h"

namespace vitrine {

namespace {

constexpr int kFineCells = 160;          // along the longest side of an object
constexpr int kNearSurface = 2;          // cells of the coarse hull: distance to its surface that contains the fine surface
constexpr size_t kMostFaces = 8000;      // of appendages
constexpr double kSunk = 1, kBulge = 2;  // fine cells above the solid: a lower point is inside the solid; bulge of a hull
constexpr double kLikeTheSolid = 0.8;    // cosine of the angle between the normals of a bulge and of the solid
constexpr double kFarOut_rel = 0.3;      // of the largest radius: minimum reach of an appendage
constexpr double kRootWay = 1.25;        // path to the solid at most this factor longer than the straight one: a connection
constexpr double kThinning = 2;          // fine cells

// Classifies points by the coarse hull: 1 inside, 0 outside, -1 near its surface.
class CoarseHull {
 public:
  explicit CoarseHull(const VoxelGrid<uint8_t>& carved) : grid_{carved.origin, carved.cell, carved.size, {}} {
    grid_.values.assign(grid_.count(), 0);
    carved.each([&](int x, int y, int z) {
      int8_t& value = grid_.values[grid_.index(x, y, z)];
      value = carved.at(x, y, z) ? 1 : 0;
      for (int k = -kNearSurface; k <= kNearSurface; ++k)
        for (int j = -kNearSurface; j <= kNearSurface; ++j)
          for (int i = -kNearSurface; i <= kNearSurface; ++i)
            if (carved.at(x + i, y + j, z + k) != carved.at(x, y, z)) value = -1;
    });
  }
  int operator()(const Vec3d& p) const { return grid_.at(p); }

 private:
  VoxelGrid<int8_t> grid_;
};

// Test for points of appendages, up to their roots. Masks propagated from few marks are too wide next to an appendage: then only
// points far from the solid count, and those that connect them to it.
class AppendageTest {
 public:
  // `mesh`: with normals.
  AppendageTest(const TriMesh& mesh, std::span<const SurfaceOfRevolution> solids, double cell, bool propagated)
      : solids_(solids), cell_(cell), propagated_(propagated) {
    if (!propagated) return;
    std::vector<Above> above(mesh.positions.size());
    parallel_for(above.size(), 256, [&](size_t v) { above[v] = nearest(cast<double>(mesh.positions[v])); });
    std::set<std::array<int, 3>> taken;  // cubes of kThinning cells: one point each is enough
    for (size_t v = 0; v < above.size(); ++v) {
      const Vec3d p = cast<double>(mesh.positions[v]), q = p / (kThinning * cell);
      if (above[v].far && taken.insert({int(std::floor(q.x)), int(std::floor(q.y)), int(std::floor(q.z))}).second)
        far_.push_back({p, above[v].height});
    }
  }
  bool operator()(const Vec3d& p, const Vec3d& normal) const {
    for (const SurfaceOfRevolution& solid : solids_) {
      const ShapePoint on = solid.nearest(p);
      const double height = dot(p - on.position, on.normal);
      if (height < kSunk * cell_ || (height < kBulge * cell_ && dot(on.normal, normal) > kLikeTheSolid)) return false;
    }
    if (!propagated_) return true;
    const Above above = nearest(p);
    return above.far || on_the_way(p, above.height);
  }
  bool is_far(const Vec3d& p) const { return nearest(p).far; }

 private:
  struct Above {
    double height = 1e300, radius = 0;
    ShapePoint on;
    bool far = true;  // from all solids
  };
  struct Far {
    Vec3d place;
    double height;
  };
  Above nearest(const Vec3d& p) const {
    Above out;
    for (const SurfaceOfRevolution& solid : solids_) {
      const ShapePoint on = solid.nearest(p);
      const double height = dot(p - on.position, on.normal), radius = solid.largest_radius();
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

  const std::span<const SurfaceOfRevolution> solids_;
  const double cell_;
  const bool propagated_;
  std::vector<Far> far_;
};

// Components that reach far from the solid. Under a foot and above a lid no silhouette limits the hull, so it bulges there.
TriMesh far_out(const TriMesh& mesh, const AppendageTest& is_appendage) {
  const FaceComponents pieces = face_components(mesh);
  std::vector<uint8_t> far(pieces.faces.size(), 0), keep(mesh.faces.size());
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (size_t c = 0; c < 3 && !far[pieces.label[f]]; ++c)
      far[pieces.label[f]] = is_appendage.is_far(cast<double>(mesh.positions[mesh.faces[f][c]]));
  for (size_t f = 0; f < keep.size(); ++f) keep[f] = far[pieces.label[f]];
  return submesh(mesh, keep);
}

}  // namespace

TriMesh appendages(const MaskedObject& object, std::span<const SurfaceOfRevolution> solids, const CarvingRule& rule,
                   bool propagated) {
  const Bounds3& bounds = object.hull.bounds();
  const Vec3d extent = bounds.high - bounds.low;
  const double cell = std::min(object.hull.voxel(), std::max({extent.x, extent.y, extent.z}) / kFineCells);
  const TriMesh mesh = fine_hull(Carving(object.silhouettes, rule), bounds, cell, CoarseHull(object.hull.carved()));
  const AppendageTest is_appendage(mesh, solids, cell, propagated);
  std::vector<uint8_t> out(mesh.positions.size(), 0), keep(mesh.faces.size());
  parallel_for(out.size(), 256, [&](size_t v) {
    const Vec3d p = cast<double>(mesh.positions[v]), n = cast<double>(mesh.normals[v]);
    size_t facing = 0;
    for (const Silhouette& s : object.silhouettes) facing += dot(n, s.view.centre_in_world() - p) > 0;
    out[v] = facing >= rule.fewest_views && is_appendage(p, n);
  });
  for (size_t f = 0; f < mesh.faces.size(); ++f)
    for (uint32_t v : mesh.faces[f]) keep[f] |= out[v];
  const TriMesh standing = far_out(submesh(mesh, keep), is_appendage);
  return standing.faces.size() > kMostFaces ? decimated(standing, {.target_faces = kMostFaces}) : standing;
}

}  // namespace vitrine
