// Photos of fisheye lenses that no single pinhole picture shows are cut into views (core/scene/camera/wide_views.h) once their
// lens and pose are known. Later stages see the views as photos of a rig.
#pragma once

#include <map>
#include <vector>

#include "core/intake/photos/photo_list.h"
#include "core/scene/camera/wide_views.h"

namespace vitrine {

class StageContext;

// The pictures that later stages use.
struct CutPhotos {
  ColmapModel model;                        // an image for each picture, with the pose, lens and pixels of its photo
  std::vector<Undistortion> undistortions;  // of each camera of `model`
  std::vector<Photo> photos;                // of the capture; photos that are cut are replaced by their views
  std::map<std::string, Photo> ingested;    // by name of a view: the photo that it is cut from
  size_t cut = 0;                           // photos
  std::vector<double> fields_deg;           // of the lenses that are cut (wide_views.h)

  const Photo& photo_of(const Photo& picture) const;  // itself if it is not cut
};
// Radius of the picture of a lens around `centre` (core/scene/camera/lens_circle.h), 0 = none. `pictures`: 8-bit, of one camera.
double lens_circle_px(std::span<const std::filesystem::path> pictures, int width, int height, const Vec2d& centre);

// `folder`: of ingest, whose pictures show where the lens ends (core/scene/camera/lens_circle.h).
CutPhotos cut_photos(const ColmapModel& model, const std::vector<Photo>& photos, const std::filesystem::path& folder);

// Metric `wide_photos`; nothing if no photo is cut.
void report_cut_photos(const CutPhotos& cut, StageContext& context);

}  // namespace vitrine
