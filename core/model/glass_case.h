// A display case: a box whose faces are clear panes, but for those that stand on something or are its frame.
#pragma once

#include <array>

#include "core/shape/box.h"

namespace vitrine {

struct GlassCase {
  Box box;
  std::array<bool, Box::kFaces> clear{true, true, true, true, true, true};  // [Box::Face::index]
};

}  // namespace vitrine
