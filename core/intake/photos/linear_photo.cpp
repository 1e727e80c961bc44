#include "core/intake/photos/linear_photo.h"

#include <algorithm>

#include "core/foundation/base/file.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"

namespace vitrine {

namespace {

constexpr float kHalfMax = 65504.0f;  // largest value in the written EXR files

// Empty when constant, as for masks (core/intake/masks/mask_files.h).
ImageF unless_flat(ImageF alpha) {
  const auto [low, high] = std::minmax_element(alpha.data().begin(), alpha.data().end());
  return alpha.empty() || !(*low < *high) ? ImageF() : std::move(alpha);
}

ImageF ldr_alpha(const ImageF& image) {
  const size_t channels = static_cast<size_t>(image.channels());
  if (channels != 2 && channels != 4) return {};
  ImageF alpha(image.width(), image.height(), 1);
  for (size_t i = 0; i < alpha.data().size(); ++i) alpha.data()[i] = image.data()[channels * (i + 1) - 1];
  return unless_flat(std::move(alpha));
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
  if (head.probe.format == PhotoFormat::Raw) {
    p.linear = read_raw_photo(path, head.balance, false);
  } else if (exr) {
    ExrPicture picture = read_exr_picture(path, head.alpha);
    p.linear = std::move(picture.rgb);
    p.alpha = unless_flat(std::move(picture.alpha));
  } else {
    p.linear = read_unchanged(path);
    p.alpha = ldr_alpha(p.linear);
    if (p.linear.channels() != 3) p.linear = three_channels(p.linear);
  }
  if (exr || head.probe.float_samples) {
    p.repaired = repair_values(p.linear, -kHalfMax);
    head.color.profile->float_to_linear(p.linear);
    repair_values(p.linear, -kHalfMax);
  } else {
    head.color.profile->to_linear(p.linear);
  }
  return p;
}

Image8 srgb_of(const Image8& decoded, const PhotoColor& color) {
  if (color.profile->is_srgb()) return decoded;
  ImageF image = floats_of(decoded);
  color.profile->to_linear(image);
  return srgb8_from_linear(image);
}

bool has_varying_alpha(const fs::path& path, const PhotoHead& head) {
  if (!head.alpha) return false;
  if (head.probe.format == PhotoFormat::Exr) return !unless_flat(read_exr_picture(path, true).alpha).empty();
  return !ldr_alpha(read_unchanged(path)).empty();
}

namespace {

ImageF limited(ImageF image, int side) {
  const int longest = std::max(image.width(), image.height());
  if (longest <= side) return image;
  const double s = double(side) / longest;
  return resized(image, std::max(int(image.width() * s + 0.5), 1), std::max(int(image.height() * s + 0.5), 1));
}

}  // namespace

Image8 reduced_photo(const std::filesystem::path& path, const PhotoHead& head, int side) {
  const Probe& probe = head.probe;
  if (probe.format == PhotoFormat::Raw) {
    const bool half = int(std::max(probe.width, probe.height)) / 2 >= side;
    return srgb8_from_linear(limited(read_raw_photo(path, head.balance, half), side));
  }
  if (probe.format == PhotoFormat::Exr || probe.float_samples)
    return srgb8_from_linear(limited(read_linear_photo(path, head).linear, side));
  int reduction = 1;
  while (reduction < 8 && int(std::max(probe.width, probe.height)) / (2 * reduction) >= side) reduction *= 2;
  return srgb_of(read_srgb8(path, reduction), head.color);
}

Image8 upright_photo(const std::filesystem::path& path, const PhotoHead& head, int side) {
  const ImageF srgb = floats_of(reduced_photo(path, head, side));
  return srgb8_from_linear(limited(linear_from_srgb_image(upright(srgb, head.exif.orientation)), side));
}

PhotoSize upright_size(const PhotoHead& head) {
  const PhotoSize stored{int(head.probe.width), int(head.probe.height)};
  return head.exif.orientation >= 5 ? PhotoSize{stored.height, stored.width} : stored;
}

}  // namespace vitrine
