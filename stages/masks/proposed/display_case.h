// A display case that nobody marked: a box that stands upright by its edges (core/observe/stereo/standing_boxes.h), and that one sees
// into. A crate has such edges, too, but stereo finds its sides; behind glass it finds what is in the case, or behind it.
#pragma once

#include <span>

#include "core/scene/camera/view_set.h"
#include "core/observe/stereo/patch_match.h"
#include "core/observe/stereo/standing_boxes.h"

namespace vitrine {

struct DisplayCase {
  Box box;                    // its foot where the photos have what it stands on
  double posts = 0, rim = 0;  // StandingBox
  double seen_through = 0;    // share of the known pixels of the side at which that is least
};

// Where to look: around what was walked around. Empty without sparse points.
Bounds3 about_standing_boxes(const ViewSet& set);
// Those of the boxes (best first) that are of glass, none in another. `maps`: of each view, of its size.
std::vector<DisplayCase> display_cases(std::span<const StandingBox> boxes, std::span<const View> views,
                                       std::span<const DepthMap> maps);

// 1 where the case is seen and nothing known stands before it, [h,w] of the view.
std::vector<uint8_t> case_mask(const DisplayCase& glass, const View& view, const DepthMap& map);

}  // namespace vitrine
