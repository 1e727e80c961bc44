// Reliability of each kind of surface: glass, specular, and the rest. Combines the support by photos (sparse points, views per
// point, confidence of normals) with the quality in held-out views.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/scene/camera/view.h"
#include "pipeline/report_page/figures.h"

namespace vitrine {

struct RegionTrust {
  std::string id, title;
  double share = 0;                          // fraction of the pixels
  std::optional<double> psnr, train_psnr;    // held-out and training views
  double heldout_views = 0;                  // number of views in the mean of `psnr`
  double points = 0;                         // sparse points per photo and tenth of the picture's area
  std::optional<double> views_per_point;     // median
  std::optional<double> normals_confidence;  // mean, 0 to 1
  std::optional<Rating> trust;               // good = high, borderline = medium, bad = low
  std::string why;
};

// Uses at most twelve photos. Without masks there is one region, the whole picture; without a sparse model there is none.
std::vector<RegionTrust> region_trust(const fs::path& project, const ViewSet& views, const Figures& figures);

// Camera positions of the photos: plan and elevation as inline SVG, and gaps as text.

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
