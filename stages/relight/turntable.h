// Turntable camera path: orbit about the vertical axis through the point that the photos look at, at their median distance and
// height. If the photos leave a wide gap, the camera oscillates over the covered arc.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"

namespace vitrine {

// The point closest to the optical axes of all views (least squares).
Vec3d point_looked_at(std::span<const View> views);
// `frames` cameras with the intrinsics of the first view, named frame_0000.png onwards.
std::vector<View> turntable_views(std::span<const View> photos, int frames);

}  // namespace vitrine
