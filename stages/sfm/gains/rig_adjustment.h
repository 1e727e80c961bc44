// Bundle adjustment of rigs: cameras of one body with known rotations and one centre (views of a panorama). All lenses are fixed.
#pragma once

#include <span>

#include "core/scene/camera/colmap_model.h"

namespace vitrine {

struct RigCamera {
  size_t body = 0;    // cameras of one body have one centre
  Quatd from_body{};  // cam_from_body
};

struct RigAdjustment {
  size_t observations = 0;
  double error_before = 0, error_after = 0;  // RMS reprojection error, pixels (robust)
};

// `cameras`: one per image of the model. Start: body poses of the first image of each body. Bodies and points are adjusted, and
// the poses of all images follow from their bodies. Single-threaded: same result on every machine of an instruction set.
RigAdjustment adjust_rigs(ColmapModel& model, std::span<const RigCamera> cameras);

}  // namespace vitrine
