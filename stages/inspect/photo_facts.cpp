#include "stages/inspect/photo_facts.h"

#include <mutex>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/intake/photos/linear_photo.h"
#include "core/scene/camera/lens_circle.h"
#include "core/scene/image/ldr.h"

namespace vitrine {

namespace {

constexpr int kMeasuredSide = 1000;  // decoded size of the longest side: at least this, less than twice this

constexpr const char* kFisheyeNote =
    "a fisheye photo (a circle with black around it): its lens model is needed, from poses that have it (--poses), or found by "
    "--set "
    "sfm.camera_model=OPENCV_FISHEYE";

PhotoFacts facts_of(const PhotoFile& file) {
  PhotoFacts f;
  f.name = file.name;
  try {
    const PhotoHead head = read_photo_head(file.path, file.balance);
    const Image8 picture = reduced_photo(file.path, head, kMeasuredSide);
    f.measures = measured(picture);
    const PhotoSize size = upright_size(head);
    f.width = size.width, f.height = size.height;
    if (f.width == 0 || f.height == 0) {
      f.width = picture.width(), f.height = picture.height();
      if (head.exif.orientation >= 5) std::swap(f.width, f.height);
    }
    f.notes = head.notes;
    const Panorama panorama =
        panorama_of(head.gpano, f.width, f.height, [&] { return upright(floats_of(picture), head.exif.orientation); });
    if (panorama.kind != PanoramaKind::None) f.notes.push_back(panorama.sentence());
    f.panorama = panorama.kind == PanoramaKind::Sphere;
    if (panorama.kind == PanoramaKind::None && shows_lens_circle(floats_of(picture))) f.notes.push_back(kFisheyeNote);
    if (!f.panorama) {
      if (const auto focal = focal_of(head.exif, f.width, f.height)) f.focal_px = focal->px;
      f.zoom = zoom_of(head.exif);
    }
    f.exposure_ev = exposure_ev(head.exif);
    f.gps = head.exif.gps;
    f.camera = head.exif.camera;
    f.time = head.exif.time;
    f.digest = head.digest.hex();
    f.color = color_facts(head.color, has_varying_alpha(file.path, head));
  } catch (const Error& e) {
    if (e.kind() != ErrorKind::Input) throw;
    f.failure = e.detail().why.empty() ? e.message() : e.detail().why;
  }
  return f;
}

}  // namespace

std::optional<double> PhotoFacts::blur() const {
  if (!measures.blur_px) return std::nullopt;
  return *measures.blur_px * kBlurSide / std::max(measures.width, measures.height);
}

std::vector<PhotoFacts> photo_facts(const PhotoFolder& folder, const std::function<void(size_t)>& progress) {
  std::vector<PhotoFacts> facts(folder.photos.size());
  size_t done = 0;
  std::mutex reporting;
  parallel_for(facts.size(), 1, [&](size_t i) {
    throw_if_interrupted();
    facts[i] = facts_of(folder.photos[i]);
    const std::lock_guard lock(reporting);
    progress(++done);
  });
  return facts;
}

}  // namespace vitrine
