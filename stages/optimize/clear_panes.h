// Classification of the faces of a glass box as panes or opaque faces.
#pragma once

#include <span>
#include <vector>

#include "core/scene/shape/shape_set.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

namespace vitrine {

// Marks faces as opaque if training photos show a surface right at the face for most pixels of the transparent masks whose rays
// leave through it: the floor of a display case is no pane, though the masks end there. Other faces are clear. Entries that are
// not boxes, or whose clear faces are given, are returned unchanged. `depths`: [photo] z-depth of the diffuse layer at `level`, 0
// = none; empty for held-out photos.
ShapeSet::Entry with_clear_panes(ShapeSet::Entry sheet, const Capture& capture, const Targets& targets,
                                 std::span<const std::vector<float>> depths, size_t level);

}  // namespace vitrine
