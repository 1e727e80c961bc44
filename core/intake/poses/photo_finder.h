// Finds the photos of a capture by the names used in external files (core/foundation/config/photo_name_finder.h).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/intake/photos/photo_list.h"
#include "core/foundation/config/photo_name_finder.h"

namespace vitrine {

// Photos are found by their path below the user's photo folder and by their own name.
class PhotoFinder : public PhotoNameFinder {
 public:
  explicit PhotoFinder(std::span<const Photo> photos);
};

// Groups photos that are versions of one picture, as data sets store them: "images_2/a.jpg" has half the size of
// "images/a.jpg", and 3D Gaussian splatting's script undistorts "input/a.jpg" into "images/a.jpg". Per photo: the first of its
// versions, possibly itself.
std::vector<size_t> first_versions(std::span<const Photo> photos);

}  // namespace vitrine
