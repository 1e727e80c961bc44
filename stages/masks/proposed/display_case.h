// Detection of unmarked display cases: upright boxes with visible edges (core/observe/stereo/upright_edges.h) and transparent
// sides. A crate has such edges as well, but there stereo reconstructs the sides; with glass it reconstructs the content or the
// background.
#pragma once

#include <span>

#include "core/observe/stereo/patch_match.h"
#include "core/observe/stereo/upright_edges.h"
#include "core/scene/camera/view_set.h"

namespace vitrine {

struct DisplayCase {
  Box box;                    // its bottom is at the height of the supporting surface
  double posts = 0, rim = 0;  // StandingBox
  double seen_through = 0;    // share of the known pixels whose surface lies behind a side; minimum over the sides
};

// Search region: the volume that the cameras surround. Empty without sparse points.
Bounds3 about_standing_boxes(const ViewSet& set);
// The boxes (best first) that are glass; none inside another. `maps`: one per view, of its size.
std::vector<DisplayCase> display_cases(std::span<const StandingBox> boxes, std::span<const View> views,
                                       std::span<const DepthMap> maps);

// [h,w] of the view: 1 where the case is visible and not occluded by a known surface.
std::vector<uint8_t> case_mask(const DisplayCase& glass, const View& view, const DepthMap& map);

}  // namespace vitrine
