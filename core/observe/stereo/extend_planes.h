// Fills the pixels of a depth map that stereo left unreliable (a wall behind an object, a border that only one photo sees,
// textureless plaster). Candidates per pixel: the planes of the nearest reliable pixels (nearest along paths that avoid
// brightness edges, so that a wall is extended from the wall and not from the vase in front of it), a large plane of the scene
// within a few of its own extents, or the far background (the sky above the wall, at background_z). The cost is the brightness
// residual in the other photos plus a penalty for occluding their reliable surfaces; costs are filtered over similar pixels and
// the cheapest candidate is used (Hosni et al., "Fast Cost-Volume Filtering for Visual Correspondence and Beyond", 2013).
#pragma once

#include "core/observe/stereo/scene_planes.h"

namespace vitrine {

// The map of photo `index` with zdepth and normal replaced where pixels are not reliable(). A map without reliable pixels is
// returned unchanged.
DepthMap extended(std::span<const StereoPhoto> photos, std::span<const DepthMap> maps, std::span<const ScenePlane> planes,
                  size_t index);

}  // namespace vitrine
