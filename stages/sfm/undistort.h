// A whole model without lens distortion; single pictures and pixels: core/camera/undistort.h.
#pragma once

#include <vector>

#include "core/camera/undistort.h"

namespace vitrine {

// Cameras become PINHOLE, observations follow, 2D points without a 3D point leave. Points seen less than twice leave, too.
ColmapModel undistorted(const ColmapModel& model, const std::vector<Undistortion>& per_camera);

}  // namespace vitrine
