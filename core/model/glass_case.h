// A display case: a box whose faces are clear panes, but for those that stand on something or are its frame.
#pragma once

#include <array>

#include "core/math/oriented_box.h"

namespace vitrine {

struct GlassCase {
  OrientedBox box;
  std::array<bool, OrientedBox::kFaces> clear{true, true, true, true, true, true};  // [OrientedBox::Face::index]
};

}  // namespace vitrine
