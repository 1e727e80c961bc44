#include "stages/ingest/develop.h"

#include <algorithm>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/scene/camera/view.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/resample.h"
#include "core/intake/photos/linear_photo.h"

namespace vitrine::ingest {

namespace {

constexpr int kPreviewSide = 512;  // of the picture in which panoramas are recognised

}  // namespace

Developed develop(const fs::path& path, int max_side, const RawBalance& balance) {
  Developed d;
  const PhotoHead head = read_photo_head(path, balance);
  const Probe& probe = head.probe;
  const Exif& exif = head.exif;

  d.digest = head.digest;
  d.notes = head.notes;
  d.aside = head.aside;

  LinearPhoto decoded = read_linear_photo(path, head);
  d.linear = std::move(decoded.linear);
  d.repaired = decoded.repaired;
  d.color = color_facts(head.color, !decoded.alpha.empty());
  if (d.linear.empty())
    throw Error(ErrorKind::Input, "a photo cannot be used",
                {.where = path.string(), .why = "it has no pixels", .hint = "take it out of the folder", .code = "BAD_PHOTO"});
  if (exif.orientation != 1) d.linear = upright(d.linear, exif.orientation);

  Photo& photo = d.photo;
  photo.original_width = d.linear.width();
  photo.original_height = d.linear.height();
  photo.orientation = probe.format == PhotoFormat::Exr ? 1 : std::clamp(exif.orientation, 1, 8);
  const Panorama panorama = panorama_of(head.gpano, photo.original_width, photo.original_height, [&] {
    const Intrinsics small = Intrinsics{photo.original_width, photo.original_height, 1, 1, 0, 0}.limited_to(kPreviewSide);
    return srgb_from_linear_image(resized(d.linear, std::max(small.width, 1), std::max(small.height, 1)));
  });
  d.panorama = panorama.kind == PanoramaKind::Sphere;
  if (d.panorama)
    d.aside += (d.aside.empty() ? "" : "; ") + panorama.sentence();
  else if (panorama.kind != PanoramaKind::None)
    d.notes.push_back(panorama.sentence());
  if (d.panorama) max_side = 0;
  const Intrinsics limited = Intrinsics{photo.original_width, photo.original_height, 1, 1, 0, 0}.limited_to(max_side);
  photo.width = std::max(limited.width, 1);
  photo.height = std::max(limited.height, 1);
  if (photo.width != photo.original_width || photo.height != photo.original_height)
    d.linear = resized(d.linear, photo.width, photo.height);
  if (const auto focal = d.panorama ? std::nullopt : focal_of(exif, photo.width, photo.height)) {
    photo.focal_px = focal->px;
    photo.focal_source = focal->source;
  }
  photo.zoom = zoom_of(exif);
  photo.exposure_ev = exposure_ev(exif);
  photo.flash = exif.flash;
  photo.gps = exif.gps;
  photo.cut_out = d.color.alpha;
  photo.camera = exif.camera;
  photo.time = exif.time;
  photo.color_profile = d.color.profile;
  photo.color_source = d.color.source;
  return d;
}

size_t develop_bytes(size_t pixels) {
  // Worst case, 16 bits with alpha: the decoder's copy, its float copy, our copy with alpha, and our copy without.
  constexpr size_t kBytesPerPixel = 8 + 16 + 16 + 12;
  return pixels * kBytesPerPixel;
}

}  // namespace vitrine::ingest
