// Lens undistortion with one resampling in linear light. The result is a PINHOLE camera with the same focal lengths; the crop
// moves the principal point by whole pixels only. The crop is the largest inner rectangle without black borders: with u(p) the
// undistorted position of pixel p,
//   left = max over the left border of u.x, right = min over the right border, top and bottom alike.
// Of fisheye lenses at most 50 degrees to each side of the axis are left.
#pragma once

#include "core/scene/camera/colmap_model.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct Undistortion {
  ColmapCamera source;
  Intrinsics target;
  bool identity = false;  // no pixel moves by more than kInvisible pixels: images are copied
};

// Throws Error{Input} if the distortion folds over inside the image, or less than a quarter of it remains.
Undistortion undistortion(const ColmapCamera& camera);
// Catmull-Rom; the source size must equal `u.source`.
ImageF undistorted(const ImageF& linear, const Undistortion& u);
// Undistorted position of a photo pixel; nullopt where the distortion cannot be inverted.
std::optional<Vec2d> undistorted(const Vec2d& pixel, const Undistortion& u);

}  // namespace vitrine
