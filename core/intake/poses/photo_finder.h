// The photos of a capture by the names that stand in somebody's file (core/foundation/config/photo_name_finder.h).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/intake/photos/photo_list.h"
#include "core/foundation/config/photo_name_finder.h"

namespace vitrine {

// Photos are found by their path below the user's photo folder, and by their own name.
class PhotoFinder : public PhotoNameFinder {
 public:
  explicit PhotoFinder(std::span<const Photo> photos);
};

// Photos that are one picture in several versions, as data sets have them side by side: "images_2/a.jpg" has half the size of
// "images/a.jpg", and "input/a.jpg" is what 3D Gaussian splatting's script undistorted into "images/a.jpg". Per photo: the first
// of its versions, perhaps itself.
std::vector<size_t> first_versions(std::span<const Photo> photos);

}  // namespace vitrine
