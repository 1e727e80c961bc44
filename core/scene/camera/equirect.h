// Equirectangular pictures: columns are longitudes, rows latitudes, 2:1 for the whole sphere. Camera frame as for pinholes: +x
// right, +y down, +z forward, which is the middle of the picture. With pixel centres at .5, of a picture of w x h pixels:
//   longitude = 2 pi (x / w - 1/2), to the right;   latitude = pi (y / h - 1/2), downwards
//   direction = (cos lat sin lon, sin lat, cos lat cos lon)
#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/math/vec.h"
#include "core/scene/image/image.h"
#include "core/scene/image/resample.h"

namespace vitrine {

// Unit direction in the camera frame of pixel coordinates (x, y).
inline Vec3d equirect_direction(double x, double y, int width, int height) {
  const double lon = 2 * std::numbers::pi * (x / width - 0.5), lat = std::numbers::pi * (y / height - 0.5);
  return {std::cos(lat) * std::sin(lon), std::sin(lat), std::cos(lat) * std::cos(lon)};
}

// Pixel coordinates of a direction of any length but 0, x in [0, width].
inline Vec2d equirect_pixel(const Vec3d& direction, int width, int height) {
  const double lon = std::atan2(direction.x, direction.z);
  const double lat = std::asin(std::clamp(direction.y / length(direction), -1.0, 1.0));
  return {(lon / (2 * std::numbers::pi) + 0.5) * width, (lat / std::numbers::pi + 0.5) * height};
}

// Lookup of directions in an equirectangular picture without a seam: copies of border pixels continue it across its left and
// right edges, and across the poles, where the opposite meridian follows.
class EquirectSampler {
 public:
  explicit EquirectSampler(const ImageF& picture)
      : width_(picture.width()), height_(picture.height()), padded_(width_ + 2 * kPad, height_ + 2 * kPad, picture.channels()) {
    for (int y = -kPad; y < height_ + kPad; ++y) {
      const bool over_pole = y < 0 || y >= height_;
      const int row = std::clamp(y < 0 ? -1 - y : over_pole ? 2 * height_ - 1 - y : y, 0, height_ - 1);
      for (int x = -kPad; x < width_ + kPad; ++x) {
        const int column = (x + (over_pole ? width_ / 2 : 0) + 2 * width_) % width_;
        std::copy_n(picture.pixel(column, row), picture.channels(), padded_.pixel(x + kPad, y + kPad));
      }
    }
  }
  // Catmull-Rom; out[channels].
  void sample(const Vec3d& direction, float* out) const {
    const Vec2d p = equirect_pixel(direction, width_, height_);
    sample_bicubic(padded_, p.x + kPad, p.y + kPad, out);
  }

 private:
  static constexpr int kPad = 3;
  int width_, height_;
  ImageF padded_;
};

}  // namespace vitrine
