#include "core/photo/linear_photo.h"

#include <algorithm>
#include <cmath>

#include "core/base/file.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"

namespace vitrine {

namespace {

constexpr float kHalfMax = 65504.0f;  // the largest number of the EXR files that we write

size_t repair(ImageF& image) {
  size_t repaired = 0;
  for (float& v : image.data()) {
    if (!std::isfinite(v)) {
      v = 0;
      ++repaired;
    }
    v = std::clamp(v, -kHalfMax, kHalfMax);
  }
  return repaired;
}

// The last of the channels, unless it is the same everywhere. The same rule as for masks (core/camera/mask_files.h).
ImageF varying_alpha(const ImageF& image, size_t channel) {
  const size_t channels = static_cast<size_t>(image.channels());
  ImageF alpha(image.width(), image.height(), 1);
  for (size_t i = 0; i < alpha.data().size(); ++i) alpha.data()[i] = image.data()[channels * i + channel];
  const auto [low, high] = std::minmax_element(alpha.data().begin(), alpha.data().end());
  return alpha.empty() || !(*low < *high) ? ImageF() : alpha;
}

ImageF exr_alpha(const fs::path& path) {
  const ExrImage exr = read_exr(path);
  const auto found = std::find(exr.channels.begin(), exr.channels.end(), "A");
  return found == exr.channels.end() ? ImageF() : varying_alpha(exr.pixels, size_t(found - exr.channels.begin()));
}

ImageF ldr_alpha(const ImageF& image) {
  const int channels = image.channels();
  return channels == 2 || channels == 4 ? varying_alpha(image, size_t(channels) - 1) : ImageF();
}

ImageF three_channels(const ImageF& image) {
  const size_t channels = static_cast<size_t>(image.channels());
  ImageF rgb(image.width(), image.height(), 3);
  for (size_t i = 0; i < rgb.pixel_count(); ++i)
    for (size_t c = 0; c < 3; ++c) rgb.data()[3 * i + c] = image.data()[channels * i + (channels >= 3 ? c : 0)];
  return rgb;
}

}  // namespace

LinearPhoto read_linear_photo(const fs::path& path, const PhotoHead& head) {
  LinearPhoto p;
  const bool exr = head.probe.format == PhotoFormat::Exr;
  if (exr) {
    if (head.alpha) p.alpha = exr_alpha(path);
    p.linear = read_exr_rgb(path);
  } else {
    p.linear = read_unchanged(path);
    p.alpha = ldr_alpha(p.linear);
    if (p.linear.channels() != 3) p.linear = three_channels(p.linear);
  }
  if (exr || head.probe.float_samples) {
    p.repaired_values = repair(p.linear);
    head.color.profile->float_to_linear(p.linear);
    repair(p.linear);
  } else {
    head.color.profile->to_linear(p.linear);
  }
  return p;
}

Image8 srgb_of(const Image8& decoded, const PhotoColor& color) {
  if (color.profile->is_srgb()) return decoded;
  ImageF image(decoded.width(), decoded.height(), decoded.channels());
  std::transform(decoded.data().begin(), decoded.data().end(), image.data().begin(), [](uint8_t v) { return float(v) / 255.0f; });
  color.profile->to_linear(image);
  return srgb8_from_linear(image);
}

bool has_varying_alpha(const fs::path& path, const PhotoHead& head) {
  if (!head.alpha) return false;
  if (head.probe.format == PhotoFormat::Exr) return !exr_alpha(path).empty();
  return !ldr_alpha(read_unchanged(path)).empty();
}

}  // namespace vitrine
