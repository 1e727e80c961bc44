// Pieces of space that all photos agree to show something in that nothing explains (core/observe/stereo/background.h): what mirrors,
// glass where it mirrors, and what stereo cannot find. Space is carved as for a visual hull, but a photo contradicts a point only
// where it sees past it, and not where a surface hides the point.
#pragma once

#include <span>
#include <vector>

#include "core/scene/camera/view.h"
#include "core/observe/stereo/background.h"

namespace vitrine {

struct UnexplainedPiece {
  std::vector<Vec3d> places;  // middles of its voxels
  double voxel = 0;           // their edge
};

// From large to small. Nobody knows how much a pixel must differ, and how many photos may err, for things that stand near each
// other to come apart, so both are tried from strict to lax; a piece that is nearly one of a stricter try does not come again.
// `explained`: of each view. The cube around the cameras' centre that is looked at has half edges of 1.2.
std::vector<UnexplainedPiece> unexplained_pieces(std::span<const View> views, std::span<const Explanation> explained);

}  // namespace vitrine
