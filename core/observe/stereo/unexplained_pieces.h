// Carves connected regions of space whose pixels no background candidate explains (core/observe/stereo/background.h): mirrors,
// glass with reflections, and surfaces that stereo does not find. Carving follows the visual hull, but a photo contradicts a
// point only where it sees past the point, not where a surface occludes it.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/observe/stereo/background.h"

namespace vitrine {

struct UnexplainedPiece {
  std::vector<Vec3d> places;  // voxel centres
  double voxel = 0;           // voxel edge
};

// Large to small. The pixel threshold and the outlier share that separate neighbouring objects are not known, so both are tried
// from strict to lax; a piece that nearly repeats one of a stricter try is dropped. `explained`: of each view. The carved cube
// around the centre of the cameras has half edges of 1.2.
std::vector<UnexplainedPiece> unexplained_pieces(std::span<const View> views, std::span<const Explanation> explained);

}  // namespace vitrine
