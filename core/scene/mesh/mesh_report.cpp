#include "core/scene/mesh/tri_mesh.h"

#include <algorithm>
#include <vector>

#include "core/foundation/math/connected_components.h"
#include "core/scene/mesh/mesh_topology.h"

namespace vitrine {

MeshReport mesh_report(const TriMesh& mesh) {
  MeshReport r;
  r.vertices = mesh.positions.size();
  r.faces = mesh.faces.size();

  std::vector<uint8_t> used(mesh.positions.size(), 0);
  for (const auto& f : mesh.faces)
    for (uint32_t v : f) used[v] = 1;
  for (size_t v = 0; v < used.size(); ++v) {
    if (used[v])
      r.bounds.extend(cast<double>(mesh.positions[v]));
    else
      ++r.loose_vertices;
  }
  const Vec3d origin = r.bounds.empty() ? Vec3d{} : r.bounds.centre();  // near the faces, to reduce rounding errors
  for (const auto& f : mesh.faces) {
    const Vec3d a = cast<double>(mesh.positions[f[0]]) - origin, b = cast<double>(mesh.positions[f[1]]) - origin;
    const Vec3d c = cast<double>(mesh.positions[f[2]]) - origin;
    const double area = 0.5 * length(cross(b - a, c - a));
    r.area += area;
    r.volume += dot(a, cross(b, c)) / 6;
    r.degenerate_faces += !(area > 0);
  }

  DisjointSets loops(mesh.positions.size());
  std::vector<uint32_t> boundary_vertices;
  const std::vector<EdgeUse> uses = sorted_edge_uses(mesh);
  for_each_edge(uses, [&](size_t first, size_t last) {
    ++r.edges;
    if (last - first == 1) {
      ++r.boundary_edges;
      loops.unite(uses[first].low, uses[first].high);
      boundary_vertices.push_back(uses[first].low);
    } else if (last - first == 2 && uses[first].forward != uses[first + 1].forward) {
      ++r.manifold_edges;
    } else {
      ++r.nonmanifold_edges;
    }
  });
  for (uint32_t& v : boundary_vertices) v = loops.representative(v);
  std::sort(boundary_vertices.begin(), boundary_vertices.end());
  r.boundary_loops =
      static_cast<size_t>(std::unique(boundary_vertices.begin(), boundary_vertices.end()) - boundary_vertices.begin());

  const FaceComponents components = face_components(mesh);
  r.components = components.faces.size();
  for (size_t n : components.faces) r.largest_component = std::max(r.largest_component, n);
  r.euler = static_cast<int64_t>(r.vertices - r.loose_vertices) - static_cast<int64_t>(r.edges) + static_cast<int64_t>(r.faces);
  return r;
}

}  // namespace vitrine
