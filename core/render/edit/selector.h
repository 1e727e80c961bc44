// Selection conditions of an edit (stages/edit/README.md).
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/camera/mask_class.h"
#include "core/foundation/math/rigid.h"

namespace vitrine {

// A region of a photo; it selects positions at any depth.
struct EditMark {
  size_t view = 0;
  std::vector<Vec2d> polygon;  // pixels of the undistorted photo
};

// All given conditions must hold. No condition selects everything.
struct Selector {
  std::optional<MaskClass> kind = {};
  std::optional<std::string> object = {};  // name in the object table
  std::optional<Bounds3> box = {};
  std::vector<EditMark> marks = {};
  std::optional<size_t> component = {};  // of the mesh, 1 = most faces
  std::vector<Selector> except = {};     // at most one; its selection is subtracted

  // True if the selection depends on position alone, not on masks or mesh.
  bool geometric() const { return !kind && !object && !component; }
};

}  // namespace vitrine
