// A depth for every pixel: where stereo found none (a wall behind an object, the border that one photo alone sees, bare plaster),
// a plane is chosen: the one that the nearest reliable pixels continue (nearest along paths that avoid edges of brightness, so
// that a wall is continued from the wall and not from the vase in front of it), a large plane of the scene within a few of its
// own extents, or the far background (the sky above the wall, at background_z). A choice costs what it leaves unexplained in the
// other photos and where it would hide what they are sure to see; the costs are averaged over what looks alike, and the cheapest
// wins (Hosni et al., "Fast Cost-Volume Filtering for Visual Correspondence and Beyond", 2013).
#pragma once

#include "core/observe/stereo/scene_planes.h"

namespace vitrine {

// The map of photo `index` with zdepth and normal of the pixels that are not reliable() replaced. Without a reliable pixel the
// map stays as it is.
DepthMap extended(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, std::span<const ScenePlane> planes,
                  size_t index);

}  // namespace vitrine
