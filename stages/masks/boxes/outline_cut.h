// The outline of a thing in a photo that a background was predicted for: a cut of least cost through the pixels of a hull's
// silhouette, which pays where the pixels' errors speak against it, and less for an outline along edges of the photo (Boykov,
// Jolly, "Interactive Graph Cuts for Optimal Boundary and Region Segmentation", 2001; minimum cut of Boost.Graph).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/stereo/edge_field.h"

namespace vitrine {

// [h,w] 1 = thing. `error`: unexplained() of core/stereo/background.h; unknown ones follow their neighbours. `about`: the
// silhouette, outside of which nothing belongs to the thing.
std::vector<uint8_t> outline_cut(const EdgePhoto& photo, std::span<const float> error, std::span<const uint8_t> about);

}  // namespace vitrine
