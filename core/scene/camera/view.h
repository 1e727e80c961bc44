// Calibrated views. Camera frame: +x right, +y down, +z forward; pixel centres at .5; no distortion (the sfm stage undistorts
// the photos and keeps the principal point).
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/foundation/math/rigid.h"

namespace vitrine {

struct Intrinsics {  // PINHOLE, pixels
  int width = 0, height = 0;
  double fx = 0, fy = 0, cx = 0, cy = 0;

  int longest_side() const { return width > height ? width : height; }
  size_t pixel_count() const { return size_t(width) * size_t(height); }
  // Row-major index of pixel (x, y).
  size_t index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
  Intrinsics scaled_to(int new_width, int new_height) const {
    const double sx = double(new_width) / width, sy = double(new_height) / height;
    return {new_width, new_height, fx * sx, fy * sy, cx * sx, cy * sy};
  }
  // Scaled so that the longest side is at most `max_side` (0 = unchanged).
  Intrinsics limited_to(int max_side) const {
    if (max_side <= 0 || longest_side() <= max_side) return *this;
    const double s = double(max_side) / longest_side();
    return scaled_to(int(width * s + 0.5), int(height * s + 0.5));
  }
  // Direction in the camera frame with z = 1 through pixel coordinates (px, py).
  Vec3d ray(double px, double py) const { return {(px - cx) / fx, (py - cy) / fy, 1.0}; }
  bool operator==(const Intrinsics&) const = default;
};

struct View {
  std::string name = {};  // file name relative to images/, e.g. "IMG_0001.png"
  Intrinsics intrinsics = {};
  Rigid cam_from_world = {};
  // Linear photo = gain * scene radiance, per channel (exposure and white balance; mean over views = 1 in log).
  Vec3d gain{1, 1, 1};

  std::string stem() const { return std::filesystem::path(name).replace_extension().generic_string(); }
  Vec3d centre_in_world() const { return inverse(cam_from_world).translation; }
  // Direction in the world through pixel coordinates (px, py); z = 1 in the camera frame.
  Vec3d ray(double px, double py) const { return transposed_times(cam_from_world.rotation, intrinsics.ray(px, py)); }
};

struct ScenePoint {  // a triangulated SfM point
  Vec3d position;
  Vec3f linear_rgb = {};  // [0,1]
  double error_px = 0;
  std::vector<uint32_t> views = {};  // indices into ViewSet::views
};

// Calibrated capture in the normalised frame (scene_from_colmap applied): camera ring centred near 0, radius 1, up (the mean
// camera's -y) is +z (see core/conventions.md).
struct ViewSet {
  std::vector<View> views;  // sorted by name
  std::vector<ScenePoint> points;
  Similarity scene_from_colmap;
};

// Standard hold-out rule: views at index 0, every, 2*every, ... in name order; every = 0 holds none out.
inline bool is_heldout(size_t index, int every) { return every > 0 && index % static_cast<size_t>(every) == 0; }

// Common look-at point of the cameras: the point nearest to all optical axes,
//   argmin_p sum |(I - d d^T) (p - c)|^2,   c = camera centre, d = its axis
struct LookedAt {
  Vec3d point;
  // Smallest eigenvalue of the mean of I - d d^T: 0 for parallel axes, 2/3 for axes in all directions. Near 0 the point is
  // ill-conditioned.
  double spread = 0;
};
LookedAt looked_at(std::span<const View> views);  // not empty

}  // namespace vitrine
