// Where the photos were taken from: plan and elevation as inline SVG, and the gaps in words.
#pragma once

#include <optional>
#include <set>
#include <string>

#include "core/camera/view.h"

namespace vitrine {

struct RingCoverage {
  double gap_deg = 0, gap_from_deg = 0;    // widest gap in azimuth around what is looked at, counter-clockwise from +x
  double lowest_deg = 0, highest_deg = 0;  // elevation of the cameras above it
};
// Nothing when the cameras look (almost) in parallel.
std::optional<RingCoverage> ring_coverage(const ViewSet& views);
inline constexpr double kGapDrawnDeg = 40;  // narrower gaps are usual

// Drawings: cameras as small frusta (those in `heldout` of another kind), sparse points in their colours.
std::string plan_svg(const ViewSet& views, const std::set<std::string>& heldout);       // from above: x right, y up
std::string elevation_svg(const ViewSet& views, const std::set<std::string>& heldout);  // from the front: x right, z up

}  // namespace vitrine
