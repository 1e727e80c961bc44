// What a user selects of a scene: the conditions of a list of edits (stages/edit/README.md).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/camera/mask_files.h"
#include "core/math/rigid.h"

namespace vitrine {

// A region of a photo: what lies in it, near or far.
struct EditMark {
  size_t view = 0;
  std::vector<Vec2d> polygon;  // pixels of the undistorted photo
};

// All that is given must hold. Nothing given: everything.
struct Selector {
  std::optional<MaskClass> kind = {};
  std::optional<std::string> object = {};  // its name in the table of objects
  std::optional<Bounds3> box = {};
  std::vector<EditMark> marks = {};
  std::optional<size_t> component = {};  // of the mesh, 1 = most faces
  std::vector<Selector> except = {};     // one at most: what it selects is left out

  // By place alone, whatever the photos or the mesh say.
  bool geometric() const { return !kind && !object && !component; }
};

}  // namespace vitrine
