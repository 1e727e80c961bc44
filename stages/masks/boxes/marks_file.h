// What a user marks by hand in a few photos, in a YAML file (../README.md shows one):
//   size    [width, height] of the photos that were marked, in pixels; a mark may have its own
//   marks   each names its photo and its class, and has a box [left, top, right, bottom] that the thing lies in, or a polygon,
//           its outline; `thing` tells several things of a class apart
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
  bool box = false;            // the thing lies somewhere in it; else it is its outline
  std::vector<Vec2d> outline;  // pixels of the undistorted photo
};

struct MarkedThing {
  std::string name;  // "transparent", or "transparent case"
  std::string word;  // "case", or empty
  MaskClass kind = MaskClass::Object;
  std::vector<Mark> marks;  // in two photos at least, one a photo
};

struct Marks {
  std::vector<MarkedThing> things;
  std::vector<std::string> without_camera;  // marked photos that sfm could not place, as the file calls them
};

// Throws Error{Usage} that shows every mistake at its line: unknown photos and classes, boxes that are none, outlines that
// cross themselves, marks outside the picture or where the lens cannot be undone, things that are marked in one photo only. A
// photo that sfm could not place is no mistake: its marks are left out.
Marks read_marks(const std::filesystem::path& path, const MaskCapture& capture);

}  // namespace vitrine
