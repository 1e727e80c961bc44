// How the undistorted photos of an sfm artifact came from the photos as taken: pixels of a photo, where people draw, become
// pixels of the cameras, and masks of these become pixels of a photo again.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/camera/undistort.h"
#include "core/scene/camera/view_set.h"

namespace vitrine {

struct PhotoLenses {
  std::vector<Undistortion> undistortions;  // [view] from the photo as taken, as ingested, to the undistorted one
  std::vector<std::string> without_camera;  // photos that sfm could not place
};
// `set` is that of the folder. An sfm artifact without its report counts as free of distortion. Throws Error{Input}.
PhotoLenses read_photo_lenses(const std::filesystem::path& sfm_folder, const ViewSet& set);

}  // namespace vitrine
