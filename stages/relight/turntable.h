// Cameras that go around a scene as its photographer did: about the vertical axis through the point that the photos look at, at
// their median distance and height. Where the photos leave a wide gap, the camera swings to and fro over what they saw.
#pragma once

#include <span>
#include <vector>

#include "core/camera/view.h"

namespace vitrine {

// The point nearest to the optical axes of all views (least squares).
Vec3d point_looked_at(std::span<const View> views);
// `frames` cameras with the intrinsics of the first view, named frame_0000.png on.
std::vector<View> turntable_views(std::span<const View> photos, int frames);

}  // namespace vitrine
