// Pinhole projection: the pixel and the z-depth at which a view shows a point. Pixel centres lie at .5; a point in the camera
// frame is one after View::cam_from_world. Directions without an origin project as points of the camera frame.
//
// projection() is nullopt at a z-depth of `near` or less; image_point() also outside the picture, or less than `margin` pixels
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

// Without a test of the depth: behind the camera as well.
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
