// Undistortion of the photos of an sfm artifact: maps pixels of the original photos, where users mark regions, to pixels of the
// undistorted cameras, and masks of the cameras back to the photos.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/camera/undistort.h"
#include "core/scene/camera/view_set.h"

namespace vitrine {

struct PhotoLenses {
  std::vector<Undistortion> undistortions;  // [view] from the ingested original photo to the undistorted one
  std::vector<std::string> without_camera;  // photos without a pose
  bool camera_flash = false;                // the flash of the camera fired in most photos (EXIF)
};
// `set`: the views of the folder. Without a report an sfm artifact is assumed free of distortion. Throws Error{Input}.
PhotoLenses read_photo_lenses(const std::filesystem::path& sfm_folder, const ViewSet& set);

}  // namespace vitrine
