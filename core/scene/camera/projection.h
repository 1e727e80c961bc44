// Pinhole projection: world point to pixel and z-depth of a view. Pixel centres are at .5. Points in the camera frame are those
// after View::cam_from_world. Directions are projected as points of the camera frame.
//
// projection() is nullopt if z-depth <= `near`. image_point() is also nullopt outside the image or less than `margin` pixels
// from its border: x in [margin, width - margin), y alike.
#pragma once

#include <optional>

#include "core/scene/camera/view.h"

namespace vitrine {

struct ImagePoint {
  double x = 0, y = 0, z = 0;  // pixels, z-depth
};

inline bool in_picture(const ImagePoint& p, const Intrinsics& k, double margin = 0) {
  return p.x >= margin && p.y >= margin && p.x < k.width - margin && p.y < k.height - margin;
}

// No depth test: also projects points behind the camera.
inline ImagePoint projected(const Vec3d& in_camera, const Intrinsics& k) {
  return {k.fx * in_camera.x / in_camera.z + k.cx, k.fy * in_camera.y / in_camera.z + k.cy, in_camera.z};
}

inline std::optional<ImagePoint> projection(const Vec3d& in_camera, const Intrinsics& k, double near = 0) {
  if (!(in_camera.z > near)) return std::nullopt;
  return projected(in_camera, k);
}
inline std::optional<ImagePoint> projection(const Vec3d& in_world, const View& view, double near = 0) {
  return projection(view.cam_from_world * in_world, view.intrinsics, near);
}

inline std::optional<ImagePoint> image_point(const Vec3d& in_camera, const Intrinsics& k, double near = 0, double margin = 0) {
  if (!(in_camera.z > near)) return std::nullopt;
  const ImagePoint p = projected(in_camera, k);
  if (!in_picture(p, k, margin)) return std::nullopt;
  return p;
}
inline std::optional<ImagePoint> image_point(const Vec3d& in_world, const View& view, double near = 0, double margin = 0) {
  return image_point(view.cam_from_world * in_world, view.intrinsics, near, margin);
}

}  // namespace vitrine
