// Reader of the YAML file with the marks of the user (example in ../README.md):
//   size    [width, height] of the marked photos, in pixels; a mark may have its own
//   marks   each has a photo, a class, and a box [left, top, right, bottom] that contains the object, or a polygon, its outline;
//           `object` separates several objects of a class
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/foundation/math/vec.h"
#include "stages/masks/mask_source.h"

namespace vitrine {

struct Mark {
  size_t view = 0;
  bool box = false;            // box around the object; otherwise its outline
  std::vector<Vec2d> outline;  // pixels of the undistorted photo
};

struct MarkedObject {
  std::string name;  // "transparent", or "transparent case"
  std::string word;  // "case", or empty
  MaskClass kind = MaskClass::Object;
  std::vector<Mark> marks;  // in at least two photos, one per photo
};

struct Marks {
  std::vector<MarkedObject> objects;
  std::vector<std::string> without_camera;  // marked photos without a pose, by the names in the file
};

// Throws Error{Usage} with the line of every mistake: unknown photos and classes, invalid boxes, self-intersecting outlines,
// marks outside the picture or where the distortion is not invertible, objects marked in only one photo. Marks in a photo without
// a pose are ignored; they are not an error.
Marks read_marks(const std::filesystem::path& path, const MaskCapture& capture);

}  // namespace vitrine
