// Where a place in the world appears in a view.
#pragma once

#include <optional>

#include "core/camera/view.h"

namespace vitrine {

struct ImagePoint {
  double x = 0, y = 0, z = 0;  // pixels, camera z
};

// nullopt behind the camera or outside the picture.
inline std::optional<ImagePoint> image_point(const Vec3d& in_world, const Intrinsics& k, const Rigid& cam_from_world) {
  const Vec3d p = cam_from_world * in_world;
  if (!(p.z > 0)) return std::nullopt;
  const ImagePoint q{k.fx * p.x / p.z + k.cx, k.fy * p.y / p.z + k.cy, p.z};
  if (!(q.x >= 0 && q.y >= 0 && q.x < k.width && q.y < k.height)) return std::nullopt;
  return q;
}
inline std::optional<ImagePoint> image_point(const Vec3d& in_world, const View& view) {
  return image_point(in_world, view.intrinsics, view.cam_from_world);
}

}  // namespace vitrine
