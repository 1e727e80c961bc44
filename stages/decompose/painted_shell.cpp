#include "stages/decompose/painted_shell.h"

#include <algorithm>
#include <numbers>

#include "core/math/kd_tree.h"
#include "core/scene/activation.h"

namespace vitrine {

TriMesh painted_shell(const ExtendedWalls& walls, const SplatLayer& layer, std::span<const Vec3f> irradiance, float reach) {
  TriMesh shell = walls.around.shell();
  // Corners of the shell stand in the order of the texels with walls. A wall that was continued is seen where it begins.
  std::vector<Vec3f> shown;
  for (size_t t = 0; t < walls.source.size(); ++t)
    if (walls.around.wall[t]) {
      const size_t from = walls.source[t];
      shown.push_back(walls.around.centre + walls.around.distance[from] * walls.around.direction(from));
    }
  std::vector<Vec3f> positions;
  std::vector<uint32_t> index;
  for (size_t i = 0; i < layer.size(); ++i) {
    const float* p = layer.at(Attribute::Mean, i);
    if (sigmoid(*layer.at(Attribute::Opacity, i)) < 0.5f) continue;
    positions.push_back({p[0], p[1], p[2]});
    index.push_back(uint32_t(i));
  }
  const KdTreef tree(positions);
  std::vector<KdTreef::Near> near;
  constexpr float pi = std::numbers::pi_v<float>;
  for (size_t v = 0; v < shell.positions.size(); ++v) {
    tree.nearest(shown[v], 6, reach, near);
    Vec3f sum{};
    for (const KdTreef::Near& n : near) sum += irradiance[index[n.index]];
    for (size_t c = 0; c < 3; ++c) {
      const float e = near.empty() ? pi : sum[c] / float(near.size());
      shell.colors[v][c] = std::clamp(pi * shell.colors[v][c] / std::max(1e-4f, e), 0.f, kMaxAlbedo);
    }
  }
  return shell;
}

}  // namespace vitrine
