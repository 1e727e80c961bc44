// Camera positions of the photos: plan and elevation as inline SVG, and gaps as text.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/scene/camera/view.h"

namespace vitrine {

struct RingCoverage {
  double gap_deg = 0, gap_from_deg = 0;    // widest gap in azimuth around the centre, counter-clockwise from +x
  double lowest_deg = 0, highest_deg = 0;  // elevation of the cameras above the centre
};
// nullopt if the cameras look in (almost) parallel directions.
std::optional<RingCoverage> ring_coverage(const ViewSet& views);
inline constexpr double kGapDrawnDeg = 40;  // smaller gaps are usual and not drawn

// Drawings: cameras as small frusta (cameras in `heldout` are marked), sparse points in their colours.
std::string plan_svg(const ViewSet& views, const std::set<std::string>& heldout);       // from above: x right, y up
std::string elevation_svg(const ViewSet& views, const std::set<std::string>& heldout);  // from the front: x right, z up

}  // namespace vitrine
