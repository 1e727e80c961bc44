// A depth for every pixel: where stereo found none (a wall behind an object, the border that one photo alone sees, bare plaster),
// the surface of the nearest reliable pixels goes on as a plane. Nearest along paths that avoid edges of brightness, so that a
// wall is continued from the wall and not from the vase in front of it. Where the far background explains the pixel better (the sky
// above the wall), it is taken instead.
#pragma once

#include "core/stereo/patch_match.h"

namespace vitrine {

// Replaces zdepth and normal of the pixels that are not reliable(). Without a reliable pixel the map stays as it is.
void extend_planes(std::span<const StereoPhoto> photos, size_t index, DepthMap& map);

}  // namespace vitrine
