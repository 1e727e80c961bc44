#include "core/stereo/box_search.h"

#include <cmath>

namespace vitrine {

Mat3d turned(size_t axis, double angle) {
  Quatd q{std::cos(angle / 2), 0, 0, 0};
  (axis == 0 ? q.x : axis == 1 ? q.y : q.z) = std::sin(angle / 2);
  return rotation_matrix(q);
}

Box moved(const Box& box, size_t i, double step) {
  Box out = box;
  if (i < 6) {
    const size_t axis = i / 2;
    (i % 2 == 0 ? out.low : out.high)[axis] += (i % 2 == 0 ? -1 : 1) * step * length(box.high - box.low);
    return out;
  }
  const Vec3d middle = box.axes * (0.5 * (box.low + box.high));
  out.axes = box.axes * turned(i - 6, step);
  const Vec3d shift = transposed_times(out.axes, middle) - 0.5 * (box.low + box.high);
  out.low += shift, out.high += shift;
  return out;
}

}  // namespace vitrine
