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
    const View& view = views[v];
    const Intrinsics& k = view.intrinsics;
    out[v].assign(size_t(k.width) * size_t(k.height), 0);
    const Vec3d eye = view.centre_in_world();
    for (int y = 0; y < k.height; ++y)
      for (int x = 0; x < k.width; ++x) {
        const Vec3d direction = transposed_times(view.cam_from_world.rotation, k.ray(x + 0.5, y + 0.5));
        out[v][size_t(y) * size_t(k.width) + size_t(x)] = hull.first_hit(eye, direction).has_value();
      }
  });
  throw_if_interrupted();
  return out;
}

}  // namespace vitrine
