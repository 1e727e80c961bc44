#include "stages/decompose/shadow_mesh.h"

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/math/kd_tree.h"
#include "core/mesh/mesh_io.h"

namespace vitrine {

double area_of(const TriMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.faces)
    area += 0.5 * double(length(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a])));
  return area;
}

TriMesh read_shadow_mesh(const fs::path& folder) {
  const fs::path path = folder / "mesh" / "mesh.ply";
  TriMesh mesh = read_mesh_ply(path);
  const bool extended = area_of(mesh) > 0;
  if (!extended || mesh.colors.size() != mesh.positions.size())
    throw Error(ErrorKind::Input, "the mesh is not usable for shadows",
                {.where = path.string(),
                 .why = mesh.faces.empty() ? "it has no triangles"
                        : !extended        ? "its triangles have no area"
                                           : "it has no colours",
                 .hint = "run the mesh stage again",
                 .code = "NO_SURFACE"});
  return mesh;
}

std::vector<float> transmission_of(const TriMesh& mesh, const std::vector<LitPoint>& points, double voxel) {
  std::vector<Vec3f> positions;
  for (const LitPoint& p : points) positions.push_back(p.position);
  const KdTreef tree(positions);
  std::vector<float> out(mesh.positions.size(), 0.f);
  std::vector<KdTreef::Near> near;
  for (size_t v = 0; v < out.size(); ++v) {
    tree.nearest(mesh.positions[v], 1, float(6 * voxel), near);
    if (!near.empty()) out[v] = points[near[0].index].transmission;
  }
  return out;
}

}  // namespace vitrine
