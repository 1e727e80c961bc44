#include "core/scene/camera/panorama_views.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace vitrine {

namespace {

constexpr int kRing = kPanoramaViews / 2;
constexpr double kDegree = std::numbers::pi / 180, kPitch_deg = 35, kStep_deg = 360.0 / kRing;

}  // namespace

Mat3d panorama_view_rotation(int view) {
  const bool lower = view >= kRing;
  const double yaw = kDegree * kStep_deg * (view % kRing + (lower ? 0.5 : 0.0)),
               pitch = kDegree * (lower ? -kPitch_deg : kPitch_deg);
  const Vec3d right{std::cos(yaw), 0, -std::sin(yaw)};
  const Vec3d forward{std::cos(pitch) * std::sin(yaw), -std::sin(pitch), std::cos(pitch) * std::cos(yaw)};
  return transposed(Mat3d{right, cross(forward, right), forward});
}

Intrinsics panorama_view_intrinsics(int panorama_width, int max_side) {
  const int natural = std::max(int(std::lround(panorama_width / std::numbers::pi)), 2);
  const int side = max_side > 0 ? std::min(natural, max_side) : natural;
  return {side, side, 0.5 * side, 0.5 * side, 0.5 * side, 0.5 * side};
}

ImageF panorama_for_views(const ImageF& panorama, const Intrinsics& view) {
  const int width = 2 * std::max(int(std::lround(std::numbers::pi * view.fx)), 1);
  return width < panorama.width() ? resized(panorama, width, width / 2) : panorama;
}

ImageF panorama_view(const EquirectSampler& panorama, int channels, const Intrinsics& intrinsics,
                     const Mat3d& view_from_panorama) {
  ImageF view(intrinsics.width, intrinsics.height, channels);
  for (int y = 0; y < intrinsics.height; ++y)
    for (int x = 0; x < intrinsics.width; ++x)
      panorama.sample(transposed_times(view_from_panorama, intrinsics.ray(x + 0.5, y + 0.5)), view.pixel(x, y));
  return view;
}

}  // namespace vitrine
