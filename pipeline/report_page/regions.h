// How far each kind of surface can be trusted: glass, gloss, and the rest. What the photos know of it (sparse points, views per
// point, confidence of the normals) beside how well it is drawn from new places.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/camera/view.h"
#include "pipeline/report_page/figures.h"

namespace vitrine {

struct RegionTrust {
  std::string id, title;
  double share = 0;                          // of the pixels
  std::optional<double> psnr, train_psnr;    // held-out and training views
  double heldout_views = 0;                  // that `psnr` is the mean of
  double points = 0;                         // sparse points a photo, per tenth of the picture's area
  std::optional<double> views_per_point;     // median
  std::optional<double> normals_confidence;  // mean, 0 to 1
  std::optional<Rating> trust;               // good = high, borderline = medium, bad = low
  std::string why;
};

// From at most a dozen photos. Without masks there is one region, the whole picture; none when there is no sparse model.
std::vector<RegionTrust> region_trust(const fs::path& project, const ViewSet& views, const Figures& figures);

}  // namespace vitrine
