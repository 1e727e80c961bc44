#include "core/observe/stereo/edge_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/foundation/base/parallel.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr std::array<float, 3> kSmooth{0.45f, 0.24f, 0.035f};  // Gaussian of 0.85 pixels
constexpr int kAround = 10;                                    // pixels: radius of the local mean gradient
constexpr float kNoise = 0.006f;                               // gradient noise per pixel
constexpr float kAcross = 4;   // penalty on gradients along the edge, relative to those across it: limits the angle to 27 degrees
constexpr double kBorder = 2;  // pixels

ImageF smoothed(const ImageF& image) {
  ImageF across(image.width(), image.height(), image.channels()), out = across;
  const auto pass = [](const ImageF& from, ImageF& to, int dx, int dy) {
    for (int y = 0; y < from.height(); ++y)
      for (int x = 0; x < from.width(); ++x)
        for (int c = 0; c < from.channels(); ++c) {
          float sum = kSmooth[0] * from.at(x, y, c);
          for (int i = 1; i < int(kSmooth.size()); ++i)
            for (int sign : {-1, 1})
              sum += kSmooth[size_t(i)] * from.at(std::clamp(x + sign * i * dx, 0, from.width() - 1),
                                                  std::clamp(y + sign * i * dy, 0, from.height() - 1), c);
          to.at(x, y, c) = sum;
        }
  };
  pass(image, across, 1, 0);
  pass(across, out, 0, 1);
  return out;
}

// Box mean with radius kAround, clipped at the border.
std::vector<float> means_around(const std::vector<float>& values, int width, int height) {
  std::vector<double> sums(size_t(width + 1) * size_t(height + 1), 0.0);
  const auto at = [&](int x, int y) -> double& { return sums[size_t(y) * size_t(width + 1) + size_t(x)]; };
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      at(x + 1, y + 1) = double(values[size_t(y) * size_t(width) + size_t(x)]) + at(x, y + 1) + at(x + 1, y) - at(x, y);
  std::vector<float> out(values.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int x0 = std::max(0, x - kAround), x1 = std::min(width, x + kAround + 1);
      const int y0 = std::max(0, y - kAround), y1 = std::min(height, y + kAround + 1);
      out[size_t(y) * size_t(width) + size_t(x)] =
          float((at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0)) / (double(x1 - x0) * (y1 - y0)));
    }
  return out;
}

}  // namespace

EdgeField::EdgeField(const EdgePhoto& photo) : view_(photo.view), tensor_(photo.srgb.width(), photo.srgb.height(), 3, 0.f) {
  const ImageF image = smoothed(photo.srgb);
  const int w = image.width(), h = image.height();
  std::vector<float> change(image.pixel_count(), 0.f);
  for (int y = 1; y + 1 < h; ++y)
    for (int x = 1; x + 1 < w; ++x) {
      float xx = 0, yy = 0, xy = 0;
      for (int c = 0; c < 3; ++c) {
        const float gx = 0.5f * (image.at(x + 1, y, c) - image.at(x - 1, y, c));
        const float gy = 0.5f * (image.at(x, y + 1, c) - image.at(x, y - 1, c));
        xx += gx * gx, yy += gy * gy, xy += gx * gy;
      }
      float* t = tensor_.pixel(x, y);
      t[0] = xx, t[1] = yy, t[2] = xy;
      change[size_t(y) * size_t(w) + size_t(x)] = std::sqrt(xx + yy);
    }
  const std::vector<float> around = means_around(change, w, h);
  for (size_t i = 0; i < around.size(); ++i) {
    const float unit = 1 / ((around[i] + kNoise) * (around[i] + kNoise));
    for (size_t c = 0; c < 3; ++c) tensor_.data()[3 * i + c] *= unit;
  }
}

float EdgeField::along(const Vec3d& p, const Vec3d& direction) const {
  const Intrinsics& k = view_.intrinsics;
  const Vec3d q = view_.cam_from_world * p, d = view_.cam_from_world.rotation * direction;
  if (!(q.z > 1e-6)) return -1;
  const double u = q.x / q.z, v = q.y / q.z, x = k.fx * u + k.cx, y = k.fy * v + k.cy;
  if (!(x > kBorder && y > kBorder && x < k.width - kBorder && y < k.height - kBorder)) return -1;
  const auto tx = float(k.fx * (d.x - d.z * u)), ty = float(k.fy * (d.y - d.z * v));
  const float norm = tx * tx + ty * ty;
  if (!(norm > 0)) return 0;
  float t[3];
  sample_bilinear(tensor_, x, y, t);
  const float mixed = 2 * t[2] * tx * ty, across = t[0] * ty * ty + t[1] * tx * tx - mixed,
              along = t[0] * tx * tx + t[1] * ty * ty + mixed;
  const float edge = std::sqrt(std::max(across - kAcross * along, 0.f) / norm);
  return edge / (edge + 1);
}

std::vector<EdgeField> edge_fields(std::span<const EdgePhoto> photos, int max_side) {
  std::vector<std::optional<EdgeField>> made(photos.size());
  parallel_for(photos.size(), 1, [&](size_t i) {
    EdgePhoto small{photos[i].view, {}};
    small.view.intrinsics = small.view.intrinsics.limited_to(max_side);
    const Intrinsics& k = small.view.intrinsics;
    small.srgb = k == photos[i].view.intrinsics ? photos[i].srgb : resized(photos[i].srgb, k.width, k.height);
    made[i].emplace(small);
  });
  std::vector<EdgeField> fields;
  for (auto& f : made) fields.push_back(std::move(*f));
  return fields;
}

}  // namespace vitrine
