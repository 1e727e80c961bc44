// What a picture can show: most of a scene is beside a small window, and copying it costs as much as drawing the rest.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "core/camera/view.h"

namespace vitrine {

class Frustum {
 public:
  explicit Frustum(const View& view) : cam_from_world_(view.cam_from_world) {
    const Intrinsics& k = view.intrinsics;
    // Through the eye and an edge of the picture, inwards.
    sides_ = {Vec3d{k.fx, 0, k.cx + kMargin}, Vec3d{-k.fx, 0, k.width + kMargin - k.cx}, Vec3d{0, k.fy, k.cy + kMargin},
              Vec3d{0, -k.fy, k.height + kMargin - k.cy}};
    for (Vec3d& n : sides_) n = normalized(n);
  }
  // A surfel: its mean and the logarithms of its two standard deviations.
  bool may_show(const Vec3f& mean, const float* log_scale) const {
    const Vec3d p = cam_from_world_ * cast<double>(mean);
    double outside = -p.z;
    for (const Vec3d& n : sides_) outside = std::max(outside, -dot(n, p));
    return outside <= 0 || outside <= double(kReach * std::exp(std::max(log_scale[0], log_scale[1])));
  }

 private:
  static constexpr float kReach = 3.5f;  // standard deviations of a surfel's extent: beyond, it is nowhere above 1/255
  static constexpr double kMargin = 4;   // pixels, for the low-pass of the rasteriser
  Rigid cam_from_world_;
  std::array<Vec3d, 4> sides_;
};

}  // namespace vitrine
