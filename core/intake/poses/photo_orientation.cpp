#include "core/intake/poses/photo_orientation.h"

#include <utility>

#include "core/scene/camera/colmap_lens.h"

namespace vitrine {

bool swaps_sides(int orientation) { return orientation >= 5 && orientation <= 8; }

bool is_mirrored(int orientation) { return orientation == 2 || orientation == 4 || orientation == 5 || orientation == 7; }

PixelSize upright_size(const Photo& photo) { return {double(photo.width), double(photo.height)}; }

PixelSize stored_size(const Photo& photo) {
  const PixelSize upright = upright_size(photo);
  return swaps_sides(photo.orientation) ? PixelSize{upright.height, upright.width} : upright;
}

Mat3d upright_from_stored(int orientation) {
  // The flags of core/scene/image/resample.cpp: directions of the upright x and y along the stored sides.
  const double x = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7 ? -1 : 1;
  const double y = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8 ? -1 : 1;
  if (swaps_sides(orientation)) return {{0, y, 0}, {x, 0, 0}, {0, 0, 1}};
  return {{x, 0, 0}, {0, y, 0}, {0, 0, 1}};
}

Vec2d upright_pixel(const Vec2d& stored, int orientation, const PixelSize& size) {
  const Mat3d turn = upright_from_stored(orientation);
  const Vec3d from_middle{stored.x - 0.5 * size.width, stored.y - 0.5 * size.height, 0};
  const Vec3d to = turn * from_middle;
  const bool swapped = swaps_sides(orientation);
  return {to.x + 0.5 * (swapped ? size.height : size.width), to.y + 0.5 * (swapped ? size.width : size.height)};
}

ColmapCamera upright_camera(const ColmapCamera& stored, int orientation) {
  ColmapCamera camera = stored;
  const Intrinsics k = pinhole_part(stored);  // throws for unknown lens models
  const Vec2d centre = upright_pixel({k.cx, k.cy}, orientation, {double(stored.width), double(stored.height)});
  if (swaps_sides(orientation)) std::swap(camera.width, camera.height);
  const std::string_view model = colmap_camera_type(stored.model_id)->name;
  const bool two_focals = has_two_focals(stored.model_id);
  if (two_focals && swaps_sides(orientation)) std::swap(camera.params[0], camera.params[1]);
  const size_t at = two_focals ? 2 : 1;
  camera.params[at] = centre.x, camera.params[at + 1] = centre.y;
  if (model == "OPENCV" || model == "FULL_OPENCV" || model == "THIN_PRISM_FISHEYE") {
    // Tangential distortion is r2 q + 2 d (q . d) with q = (p2, p1): q rotates with the picture. Radial distortion is invariant.
    const Vec3d q = upright_from_stored(orientation) * Vec3d{stored.params[7], stored.params[6], 0};
    camera.params[7] = q.x, camera.params[6] = q.y;
  }
  if (model == "THIN_PRISM_FISHEYE") {  // the prism shifts pixels by r2 (s1, s2)
    const Vec3d s = upright_from_stored(orientation) * Vec3d{stored.params[10], stored.params[11], 0};
    camera.params[10] = s.x, camera.params[11] = s.y;
  }
  return camera;
}

Vec3d mirrored_world(const Vec3d& place) { return {-place.x, place.y, place.z}; }

Rigid upright_pose(const Rigid& cam_from_world, int orientation) {
  const Mat3d turn = upright_from_stored(orientation);
  Rigid pose{turn * cam_from_world.rotation, turn * cam_from_world.translation};
  if (is_mirrored(orientation)) pose.rotation.c0 = -pose.rotation.c0;  // R diag(-1, 1, 1)
  return pose;
}

}  // namespace vitrine
