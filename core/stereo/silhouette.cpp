#include "core/stereo/silhouette.h"

#include <algorithm>

namespace vitrine {

Silhouette silhouette(const View& view, const std::vector<uint8_t>& inside) {
  Silhouette out{view, ImageF(view.intrinsics.width, view.intrinsics.height, 1)};
  std::copy(inside.begin(), inside.end(), out.value.data().begin());
  return out;
}

}  // namespace vitrine
