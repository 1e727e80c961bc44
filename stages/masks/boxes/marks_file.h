// What a user marks by hand in a few photos, in a YAML file:
//
//   size: [4000, 3000]               # of the photos that were marked, in pixels
//   marks:
//     - photo: IMG_0012.jpg
//       class: transparent           # object, transparent, specular or ignore
//       box: [1200, 800, 2900, 2400]                 # left, top, right, bottom
//     - photo: IMG_0031.jpg
//       class: transparent
//       polygon: [[900, 700], [2100, 640], [2150, 2300], [950, 2350]]
//       size: [3000, 4000]           # of this photo, where it differs
//       thing: case                  # which of several things of a class; default: there is one
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/camera/mask_files.h"
#include "core/math/vec.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

struct Mark {
  size_t view = 0;
  bool box = false;            // the thing lies somewhere in it; a polygon is its outline
  std::vector<Vec2d> outline;  // pixels of the undistorted photo
};

struct MarkedThing {
  std::string name;  // "transparent", or "transparent case"
  MaskClass kind = MaskClass::Object;
  std::vector<Mark> marks;  // in two photos at least, one a photo
};

bool is_marks_file(const std::filesystem::path& path);  // a file that ends in .yaml
// Throws Error{Usage} that shows every mistake at its line: unknown photos and classes, boxes that are none, marks outside the
// picture, things that are marked in one photo only.
std::vector<MarkedThing> read_marks(const std::filesystem::path& path, const MaskCapture& capture);

}  // namespace vitrine
