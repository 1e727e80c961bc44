// A plane as a photo sees it: inverse depth is affine in the pixel, 1/z = a x + b y + c, so that fitting a plane to a depth map
// is a least-squares fit of three numbers.
#pragma once

#include "core/stereo/patch_match.h"

namespace vitrine {

struct InversePlane {
  double a = 0, b = 0, c = 0;  // of pixels: x, y are pixel centres
  double at(double x, double y) const { return a * x + b * y + c; }
};

// {X : normal.X = offset} of the camera frame.
InversePlane inverse_plane(const Intrinsics& k, const Vec3d& normal, double offset);
// Its normal in the camera frame, towards the camera.
Vec3d normal_towards_camera(const Intrinsics& k, const InversePlane& plane);

// Fitted to the reliable pixels within 10 pixels of the reliable pixel (x, y) that lie on its own plane, then on the fitted one.
// The pixel's own plane where they do not fix one.
InversePlane fitted_plane(const Intrinsics& k, const DepthMap& map, int x, int y);

}  // namespace vitrine
