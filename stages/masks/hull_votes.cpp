#include "stages/masks/hull_votes.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/base/process.h"

namespace vitrine {

HullMask hull_mask(const View& view, const std::vector<uint8_t>& inside) {
  const Intrinsics& k = view.intrinsics;
  HullMask mask{view, ImageF(k.width, k.height, 1)};
  std::copy(inside.begin(), inside.end(), mask.mask.data().begin());
  return mask;
}

std::vector<std::vector<uint8_t>> silhouettes(const VisualHull& hull, const std::vector<View>& views) {
  std::vector<std::vector<uint8_t>> out(views.size());
  parallel_for(views.size(), 1, [&](size_t v) {
    if (interrupt_signal() != 0) return;
    out[v] = mask_of_rays(
        views[v], [&](size_t, const Vec3d& eye, const Vec3d& direction) { return hull.first_hit(eye, direction).has_value(); });
  });
  throw_if_interrupted();
  return out;
}

}  // namespace vitrine
