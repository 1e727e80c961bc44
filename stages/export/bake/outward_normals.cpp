#include "stages/export/bake/outward_normals.h"

#include "core/math/kd_tree.h"
#include "core/math/rigid.h"

namespace vitrine {

std::vector<Vec3f> outward_normals(const SplatLayer& layer, const TriMesh& mesh, float reach) {
  const KdTreef vertices(mesh.positions);
  std::vector<KdTreef::Near> near;
  std::vector<Vec3f> out(layer.size());
  for (size_t i = 0; i < layer.size(); ++i) {
    const float *m = layer.at(Attribute::Mean, i), *q = layer.at(Attribute::Rotation, i);
    const Vec3f mean{m[0], m[1], m[2]}, normal = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c2;
    vertices.nearest(mean, 1, reach, near);
    const Vec3f side = !near.empty() ? mesh.normals[near[0].index] : squared_length(mean) > 1 ? -mean : mean;
    out[i] = dot(normal, side) < 0 ? -normal : normal;
  }
  return out;
}

}  // namespace vitrine
