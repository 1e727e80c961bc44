#include "stages/optimize/known_shapes.h"

#include <algorithm>

#include "core/mesh/mesh_topology.h"

namespace vitrine {

namespace {

constexpr double kOnSolid_rel = 0.06;       // of its largest radius: surfels that show it lie this near, appendages do not
constexpr double kOnAppendage_cells = 1.5;  // of the spacing of the hull
constexpr size_t kProfileSegments = 96;

// [face] the solid, by the mean distance of the piece that it belongs to.
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

}  // namespace

ShapeSet known_shapes(const Hull& hull) {
  ShapeSet out;
  for (const SolidOfRevolution& solid : hull.solids) {
    SurfaceOfRevolution surface = with_equal_segments(surface_of_revolution(solid), kProfileSegments);
    const double tolerance = kOnSolid_rel * surface.largest_radius();
    out.entries.push_back({std::move(surface), ShapeRole::Mirror, tolerance, -1, {}});
  }
  const size_t solids = out.entries.size();
  if (solids == 0 || hull.beside.faces.empty()) return out;
  const std::vector<uint32_t> parent = nearest_solids(hull.beside, out);
  for (size_t k = 0; k < solids; ++k) {
    std::vector<uint8_t> own(parent.size());
    std::ranges::transform(parent, own.begin(), [&](uint32_t p) { return p == k; });
    TriMesh mesh = submesh(hull.beside, own);
    if (mesh.faces.empty()) continue;
    out.entries.push_back(
        {TriangleShape(std::move(mesh)), ShapeRole::Mirror, kOnAppendage_cells * double(hull.spacing), static_cast<int>(k), {}});
  }
  return out;
}

}  // namespace vitrine
