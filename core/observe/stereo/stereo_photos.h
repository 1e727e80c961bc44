// Input of PatchMatch stereo for each photo, from the poses and sparse points of a capture.
#pragma once

#include "core/scene/camera/view_set.h"
#include "core/observe/stereo/patch_match.h"

namespace vitrine {

// Depth of the far background, in radii of the camera ring: cameras of a ring see it at most 1.1 degrees apart.
inline constexpr double kWithoutParallax = 100;

// Luma of Rec. 709 on encoded values. [h,w,3] -> [h,w,1].
ImageF luma_of_srgb(const ImageF& srgb);

// Fills `hints`, `near_z` and `far_z` of the photos that have a picture, from the sparse points that they see: [view of `set`].
// `far_factor`: factor on the depth of the farthest points.
void find_depth_ranges(const ViewSet& set, double far_factor, std::span<StereoPhoto> photos);

}  // namespace vitrine
