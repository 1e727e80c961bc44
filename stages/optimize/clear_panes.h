// Which faces of a glass box are panes.
#pragma once

#include <span>
#include <vector>

#include "core/scene/shape/shape_set.h"
#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/targets.h"

namespace vitrine {

// The floor of a display case is no pane, though its masks end there: what training photos show through the box stands right at
// that face. A face is clear unless that is so for most pixels of the transparent masks whose rays leave by it. Sheets that are
// no boxes, or whose clear faces are known, stay as they are. `depths`: [photo] z-depth of what the diffuse layer shows at
// `level`, 0 = none; empty for held-out photos.
ShapeSet::Entry with_clear_panes(ShapeSet::Entry sheet, const Capture& capture, const Targets& targets,
                                 std::span<const std::vector<float>> depths, size_t level);

}  // namespace vitrine
