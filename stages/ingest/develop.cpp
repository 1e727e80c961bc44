#include "stages/ingest/develop.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/file.h"
#include "core/camera/view.h"
#include "core/image/exr.h"
#include "core/image/ldr.h"
#include "core/image/resample.h"
#include "core/image/upright.h"
#include "core/math/color.h"
#include "core/photo/photo_files.h"

namespace vitrine::ingest {

namespace {

// All values of 8 and 16 bit samples are multiples of 1/65535, so one table decodes both exactly.
void decode_srgb(ImageF& image) {
  static const std::vector<float> table = [] {
    std::vector<float> t(65536);
    for (size_t i = 0; i < t.size(); ++i) t[i] = static_cast<float>(linear_from_srgb(static_cast<double>(i) / 65535.0));
    return t;
  }();
  // The comparison also catches NaN, which a float file in disguise may hold.
  for (float& v : image.data()) v = v > 0 ? table[static_cast<size_t>(std::min(v, 1.0f) * 65535.0f + 0.5f)] : 0.0f;
}

}  // namespace

Developed develop(const fs::path& path, int max_side) {
  Developed d;
  const PhotoHead head = read_photo_head(path);
  const Probe& probe = head.probe;
  const Exif& exif = head.exif;

  d.notes = head.notes;
  d.aside = head.aside;

  if (probe.format == PhotoFormat::Exr) {
    d.linear = read_exr_rgb(path);
    d.repaired = repair_values(d.linear);
  } else {
    d.linear = read_srgb(path);
    if (probe.float_samples)
      d.repaired = repair_values(d.linear);
    else
      decode_srgb(d.linear);
  }
  if (d.linear.empty())
    throw Error(ErrorKind::Input, "a photo cannot be used",
                {.where = path.string(), .why = "it has no pixels", .hint = "take it out of the folder", .code = "BAD_PHOTO"});
  if (exif.orientation != 1) d.linear = upright(d.linear, exif.orientation);

  Photo& photo = d.photo;
  photo.original_width = d.linear.width();
  photo.original_height = d.linear.height();
  photo.orientation = probe.format == PhotoFormat::Exr ? 1 : std::clamp(exif.orientation, 1, 8);
  const Intrinsics limited = Intrinsics{photo.original_width, photo.original_height, 1, 1, 0, 0}.limited_to(max_side);
  photo.width = std::max(limited.width, 1);
  photo.height = std::max(limited.height, 1);
  if (photo.width != photo.original_width || photo.height != photo.original_height)
    d.linear = resized(d.linear, photo.width, photo.height);
  if (const auto focal = focal_of(exif, photo.width, photo.height)) {
    photo.focal_px = focal->px;
    photo.focal_source = focal->source;
  }
  photo.exposure_ev = exposure_ev(exif);
  photo.camera = exif.camera;
  photo.time = exif.time;
  return d;
}

size_t develop_bytes(size_t pixels) {
  // Worst case, 16 bits with alpha: the decoder's copy, its float copy, ours with alpha, and ours without.
  constexpr size_t kBytesPerPixel = 8 + 16 + 16 + 12;
  return pixels * kBytesPerPixel;
}

}  // namespace vitrine::ingest
