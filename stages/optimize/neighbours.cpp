#include "stages/optimize/neighbours.h"

#include <cmath>
#include <cstdint>

#include "core/foundation/base/parallel.h"
#include "core/foundation/math/kd_tree.h"

namespace vitrine {

std::vector<float> neighbour_spacing(std::span<const Vec3f> points) {
  constexpr size_t kNearest = 3;
  const KdTreef tree(points);
  std::vector<float> spacing(points.size(), 0.f);
  parallel_for(points.size(), 256, [&](size_t i) {
    thread_local std::vector<KdTreef::Near> near;
    tree.nearest_others(static_cast<uint32_t>(i), kNearest, near);
    double sum = 0;
    for (const KdTreef::Near& n : near) sum += n.squared_distance;
    if (!near.empty()) spacing[i] = static_cast<float>(std::sqrt(sum / double(near.size())));
  });
  return spacing;
}

}  // namespace vitrine
