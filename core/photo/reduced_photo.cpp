#include "core/photo/reduced_photo.h"

#include <algorithm>

#include "core/image/ldr.h"
#include "core/image/resample.h"
#include "core/image/upright.h"
#include "core/photo/linear_photo.h"

namespace vitrine {

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
