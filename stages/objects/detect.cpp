#include "stages/objects/detect.h"

#include <algorithm>

#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/scene/mesh/clean_openmesh.h"
#include "core/scene/mesh/mesh_topology.h"
#include "core/observe/stereo/shape_fit.h"

namespace vitrine {

namespace {

constexpr double kOnBox_rel = 0.05;          // of the longest side: distance within which surfels belong to a face
constexpr double kOnSolid_rel = 0.06;        // of the largest radius: surfels within belong to the solid (appendages are farther)
constexpr double kOnAppendage_voxels = 1.5;  // of the hull
constexpr size_t kProfileSegments = 96;
constexpr size_t kMostHullFaces = 8000;
constexpr int kLookedAt = 240;  // pixels, longest side
// Free-form mesh:
constexpr size_t kFreeFormFaces = 6000;
constexpr double kOnFreeForm_rel = 0.02;  // of the mesh's size: distance within which surfels belong to it
constexpr double kLeastInside = 0.85;     // minimum share of its pixels inside the masks

// [face] nearest solid, by the mean distance of the face's connected component.
std::vector<uint32_t> nearest_solids(const TriMesh& mesh, const ShapeSet& solids) {
  const FaceComponents pieces = face_components(mesh);
  const size_t count = solids.entries.size();
  std::vector<double> away(pieces.faces.size() * count, 0.0);  // [piece][solid] sum
  for (size_t f = 0; f < mesh.faces.size() && count > 1; ++f)
    for (size_t k = 0; k < count; ++k) {
      const Vec3d p = cast<double>(mesh.positions[mesh.faces[f][0]]);
      away[pieces.label[f] * count + k] += length(nearest(solids.entries[k].shape, p).position - p);
    }
  std::vector<uint32_t> out;
  for (const uint32_t piece : pieces.label) {
    const auto first = away.begin() + static_cast<ptrdiff_t>(piece * count);
    out.push_back(static_cast<uint32_t>(std::min_element(first, first + static_cast<ptrdiff_t>(count)) - first));
  }
  return out;
}

void add_appendages(const TriMesh& mesh, double tolerance, ShapeSet& set) {
  if (mesh.faces.empty()) return;
  const size_t solids = set.entries.size();
  const std::vector<uint32_t> parent = nearest_solids(mesh, set);
  for (size_t k = 0; k < solids; ++k) {
    std::vector<uint8_t> own(parent.size());
    std::ranges::transform(parent, own.begin(), [&](uint32_t p) { return p == k; });
    TriMesh part = submesh(mesh, own);
    if (part.faces.empty()) continue;
    set.entries.push_back({TriangleShape(std::move(part)), set.entries[k].role, tolerance, static_cast<int>(k), {}});
  }
}

void add_hull(const VisualHull& hull, ShapeRole role, ShapeSet& set) {
  TriMesh mesh = hull_mesh(hull);
  if (mesh.faces.size() > kMostHullFaces) mesh = decimated(mesh, {.target_faces = kMostHullFaces});
  if (mesh.faces.empty()) return;
  set.entries.push_back({.shape = TriangleShape(std::move(mesh)),
                         .role = role,
                         .tolerance = kHullTolerance_voxels * hull.voxel(),
                         .clear = {},
                         .exact = false});
}

// Free-form shape: a closed mesh fitted to the silhouettes (core/observe/stereo/shape_fit.h), initialised from the visual hull.
std::optional<ShapeSet::Entry> free_form(const MaskedObject& object, ShapeRole role) {
  TriMesh start = hull_mesh(object.hull);
  if (start.faces.empty()) return std::nullopt;
  if (start.faces.size() > kFreeFormFaces) start = decimated(start, {.target_faces = kFreeFormFaces});
  if (start.faces.empty()) return std::nullopt;
  const MeshFit fit = fit_mesh(object.silhouettes, std::move(start));
  TriangleShape shape(fit.mesh);
  const double size = shape.size();
  ShapeSet set;
  set.entries.push_back({.shape = std::move(shape), .role = role, .tolerance = kOnFreeForm_rel * size, .clear = {}});
  const MaskAgreement agreement = mask_agreement(set, object.silhouettes);
  log_info("a mesh of size {:.2f}: {:.3f} of it inside the masks, residual {:.5f}, {:.2f} of its vertices seen at silhouettes",
           size, agreement.inside, fit.residual, fit.contacts);
  if (agreement.inside < kLeastInside) return std::nullopt;
  return std::move(set.entries.front());
}

}  // namespace

ShapeSet detected_shapes(const MaskedObject& object, const CarvingRule& rule, bool propagated) {
  const ShapeRole role = object.kind == MaskClass::Transparent ? ShapeRole::Sheet : ShapeRole::Mirror;
  ShapeSet out;
  const FittedShapes fits = fit_shapes(object.silhouettes, object.hull);
  if (fits.box) {
    out.entries.push_back({fits.box->box, role, kOnBox_rel * fits.box->box.longest_side(), -1, {}});
    return out;
  }
  for (const SurfaceOfRevolution& solid : fits.solids) {
    SurfaceOfRevolution surface = with_equal_segments(solid, kProfileSegments);
    const double tolerance = kOnSolid_rel * surface.largest_radius();
    out.entries.push_back({std::move(surface), role, tolerance, -1, {}});
  }
  if (!fits.solids.empty())
    add_appendages(appendages(object, fits.solids, rule, propagated), kOnAppendage_voxels * object.hull.voxel(), out);
  if (out.entries.empty())
    if (auto entry = free_form(object, role)) out.entries.push_back(std::move(*entry));
  if (out.entries.empty()) add_hull(object.hull, role, out);
  return out;
}

MaskAgreement mask_agreement(const ShapeSet& shapes, const std::vector<Silhouette>& silhouettes) {
  struct Count {
    size_t both = 0, shape = 0, mask = 0;
  };
  std::vector<Count> counts(silhouettes.size());
  parallel_for(silhouettes.size(), 1, [&](size_t v) {
    const Silhouette& s = silhouettes[v];
    View view = s.view;
    view.intrinsics = s.view.intrinsics.limited_to(kLookedAt);
    const Intrinsics& k = view.intrinsics;
    const auto shown = mask_of_rays(view, [&](size_t, const Vec3d& eye, const Vec3d& direction) {
      return std::ranges::any_of(shapes.entries, [&](const ShapeSet::Entry& e) {
        return intersect(e.shape, {eye, direction}).has_value();
      });
    });
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const float value = s.value.at(x * s.value.width() / k.width, y * s.value.height() / k.height);
        if (value < 0) continue;
        const bool on_shape = shown[k.index(x, y)] != 0, marked = value >= 0.5f;
        counts[v].both += on_shape && marked, counts[v].shape += on_shape, counts[v].mask += marked;
      }
  });
  Count all;
  for (const Count& c : counts) all.both += c.both, all.shape += c.shape, all.mask += c.mask;
  return {all.shape > 0 ? double(all.both) / double(all.shape) : 0, all.mask > 0 ? double(all.both) / double(all.mask) : 0};
}

}  // namespace vitrine
