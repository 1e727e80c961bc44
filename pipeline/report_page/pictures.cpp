#include "pipeline/report_page/pictures.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/math/quantile.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "pipeline/report_page/page.h"

namespace vitrine {

namespace {

constexpr int kQuality = 82;

ImageF limited(const ImageF& image, int max_side) {
  const int side = std::max(image.width(), image.height());
  if (side <= max_side) return image;
  const double scale = double(max_side) / side;
  return resized(image, std::max(1, int(std::lround(image.width() * scale))),
                 std::max(1, int(std::lround(image.height() * scale))));
}

ImageF three_channels(const ImageF& image) {
  ImageF rgb(image.width(), image.height(), 3);
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x)
      for (int c = 0; c < 3; ++c) rgb.at(x, y, c) = image.at(x, y, std::min(c, image.channels() - 1));
  return rgb;
}

// Converts display values in [0,1] to 8 bits.
Image8 rounded(const ImageF& srgb) {
  Image8 out(srgb.width(), srgb.height(), srgb.channels());
  std::transform(srgb.data().begin(), srgb.data().end(), out.data().begin(),
                 [](float v) { return uint8_t(std::clamp(v, 0.f, 1.f) * 255.f + 0.5f); });
  return out;
}

// Near is bright; the range covers the middle 96 % of the pixels, so that outliers do not reduce the contrast.
ImageF shaded_depth(const ImageF& zdepth) {
  std::vector<float> known;
  for (float z : zdepth.data())
    if (std::isfinite(z) && z > 0) known.push_back(z);
  ImageF out(zdepth.width(), zdepth.height(), 1);
  if (known.empty()) return out;
  const size_t cut = known.size() / 50;
  const float low = order_statistic_of(std::span(known), cut);
  const float high = std::max(order_statistic_of(std::span(known), known.size() - 1 - cut), low * 1.001f);
  std::transform(zdepth.data().begin(), zdepth.data().end(), out.data().begin(), [&](float z) {
    return std::isfinite(z) && z > 0 ? 0.95f - 0.85f * std::clamp((z - low) / (high - low), 0.f, 1.f) : 0.f;
  });
  return out;
}

ImageF normal_colours(const ImageF& normals) {
  ImageF out = three_channels(normals);
  for (int y = 0; y < out.height(); ++y)
    for (int x = 0; x < out.width(); ++x) {
      float* n = out.pixel(x, y);
      const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      for (int c = 0; c < 3; ++c) n[c] = length > 0.1f ? 0.5f + 0.5f * n[c] / length : 0.f;
    }
  return out;
}

constexpr int kSubpixels = 2;  // rays per pixel and axis
constexpr Vec3f kBackground{0.88f, 0.88f, 0.87f};
constexpr Vec3f kClay{0.80f, 0.77f, 0.72f};
constexpr float kAmbient = 0.18f, kHeadlight = 0.62f, kFromAbove = 0.2f;

struct Shades {
  Vec3f clay = kBackground, normal = kBackground;
};

Shades shades_of(const MeshHits& mesh, const View& view, const Vec3f& origin, double px, double py) {
  const Vec3f direction = cast<float>(normalized(transposed(view.cam_from_world.rotation) * view.intrinsics.ray(px, py)));
  const auto hit = mesh.first_hit(origin, direction);
  if (!hit) return {};
  const Vec3f n = dot(hit->normal, direction) > 0 ? -hit->normal : hit->normal;  // facing the camera: walls are single-sided
  const float light = kAmbient + kHeadlight * -dot(n, direction) + kFromAbove * std::max(0.f, n.z);
  const Vec3d in_cam = view.cam_from_world.rotation * cast<double>(n);
  return {light * kClay, {float(0.5 + 0.5 * in_cam.x), float(0.5 - 0.5 * in_cam.y), float(0.5 - 0.5 * in_cam.z)}};
}

}  // namespace

Picture picture_of(const Image8& image) {
  return {"data:image/jpeg;base64," + base64(jpeg_bytes(image, kQuality)), image.width(), image.height()};
}

Picture picture_of_linear(const ImageF& linear, int max_side) {
  return picture_of(srgb8_from_linear(limited(linear.channels() == 2 ? three_channels(linear) : linear, max_side)));
}

std::optional<Picture> picture_of_file(const fs::path& path, int max_side) {
  std::error_code ec;
  if (!fs::is_regular_file(path, ec)) return std::nullopt;
  try {
    const ImageF srgb = read_srgb(path);
    if (std::max(srgb.width(), srgb.height()) <= max_side) return picture_of(rounded(srgb));
    return picture_of_linear(linear_from_srgb_image(srgb), max_side);
  } catch (const Error&) {
    return std::nullopt;
  }
}

std::optional<Picture> picture_of_layer(const fs::path& exr, AovKind kind, int max_side) {
  std::error_code ec;
  if (!fs::is_regular_file(exr, ec)) return std::nullopt;
  try {
    const ImageF pixels = read_exr(exr).pixels;
    if (pixels.empty() || pixels.channels() < 1) return std::nullopt;
    switch (kind) {
      case AovKind::Radiance:
        return picture_of_linear(three_channels(pixels), max_side);
      case AovKind::Weight:
        return picture_of(rounded(limited(three_channels(pixels), max_side)));
      case AovKind::Normal:
        return picture_of(rounded(limited(normal_colours(pixels), max_side)));
      case AovKind::Depth:
        return picture_of(rounded(limited(shaded_depth(pixels), max_side)));
    }
  } catch (const Error&) {
  }
  return std::nullopt;
}

SurfaceView surface_view(const MeshHits& mesh, const View& original, int max_side) {
  View view = original;
  view.intrinsics = original.intrinsics.limited_to(max_side);
  const int width = view.intrinsics.width, height = view.intrinsics.height;
  const Vec3f origin = cast<float>(view.centre_in_world());
  SurfaceView out{Image8(width, height, 3), Image8(width, height, 3)};
  parallel_for(size_t(height), 4, [&](size_t row) {
    const int y = int(row);
    for (int x = 0; x < width; ++x) {
      Vec3f clay{}, normal{};
      for (int s = 0; s < kSubpixels * kSubpixels; ++s) {
        const Shades one =
            shades_of(mesh, view, origin, x + (s % kSubpixels + 0.5) / kSubpixels, y + (s / kSubpixels + 0.5) / kSubpixels);
        clay += one.clay;
        normal += one.normal;
      }
      for (size_t c = 0; c < 3; ++c) {
        constexpr float kScale = 255.f / (kSubpixels * kSubpixels);
        out.clay.pixel(x, y)[c] = uint8_t(std::clamp(kScale * clay[c] + 0.5f, 0.f, 255.f));
        out.normals.pixel(x, y)[c] = uint8_t(std::clamp(kScale * normal[c] + 0.5f, 0.f, 255.f));
      }
    }
  });
  return out;
}

}  // namespace vitrine
