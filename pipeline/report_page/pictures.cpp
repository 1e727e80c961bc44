#include "pipeline/report_page/pictures.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/base64.h"
#include "core/foundation/base/error.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/foundation/math/quantile.h"
#include "pipeline/report_page/html.h"

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

}  // namespace vitrine
