// Lens undistortion with one resampling in linear light. The result is a PINHOLE camera with the same focal lengths; the crop
// moves the principal point by whole pixels only. The crop is the largest inner rectangle without black borders: with u(p) the
// undistorted position of pixel p,
//   left = max over the left border of u.x, right = min over the right border, top and bottom alike.
// Of fisheye lenses at most 50 degrees to each side of the axis are left; photos of wider ones are cut into several pinhole views
// (wide_views.h), each with a rotation of its own.
#pragma once

#include "core/scene/camera/colmap_model.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct Undistortion {
  ColmapCamera source;
  Intrinsics target;
  bool identity = false;  // no pixel moves by more than kInvisible pixels: images are copied
  // Of a view cut from a wide photo: target_from_source, and the radius of the lens' picture around the principal point of
  // `source` in pixels, 0 = up to the borders. Pixels that the lens does not show are black in the view.
  std::optional<Mat3d> rotation = {};
  double circle_px = 0;
};

// Throws Error{Input} if the distortion folds over inside the image, or less than a quarter of it remains.
Undistortion undistortion(const ColmapCamera& camera);
// Catmull-Rom; the source size must equal `u.source`.
ImageF undistorted(const ImageF& linear, const Undistortion& u);
// Undistorted position of a photo pixel; nullopt where the distortion cannot be inverted, and behind a cut view.
std::optional<Vec2d> undistorted(const Vec2d& pixel, const Undistortion& u);
// Photo pixel that a cut view shows at `pixel`; nullopt if it lies outside the photo or the lens' picture, or where the lens
// model folds over.
std::optional<Vec2d> seen_pixel(const Undistortion& u, const Vec2d& pixel);

}  // namespace vitrine
