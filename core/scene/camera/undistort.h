// Removes lens distortion with one resampling in linear light. The result is a PINHOLE camera of the same focal lengths whose
// principal point moved only by whole pixels (the crop), and whose frame is the largest inner rectangle without black borders:
// with u(p) the undistorted position of pixel p,
//   left = max over the left border of u.x, right = min over the right border, top and bottom alike.
#pragma once

#include "core/scene/camera/colmap_model.h"
#include "core/scene/image/image.h"

namespace vitrine {

struct Undistortion {
  ColmapCamera source;
  Intrinsics target;
  bool identity = false;  // nothing moves by more than kInvisible pixels: pictures are copied
};

// Throws Error{Input} for a lens that folds over inside the frame, or leaves less than a quarter of it.
Undistortion undistortion(const ColmapCamera& camera);
// Catmull-Rom; the source must have the size of `u.source`.
ImageF undistorted(const ImageF& linear, const Undistortion& u);
// Where a pixel of the photo lands; nullopt where the lens cannot be inverted.
std::optional<Vec2d> undistorted(const Vec2d& pixel, const Undistortion& u);

}  // namespace vitrine
