// Measures that the user gives in photos, --grey-card and --scale-bar, in pixels of images/<photo>: ingested photos without the
// distortion of their lens. Checked before anything is computed, as far as the photos show it, and with the cameras of the sfm
// stage before any training.
#pragma once

#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "pipeline/plan.h"

namespace vitrine {

// Checks the format of the text ("photo:x,y,w,h"; core/foundation/config/chart.h), that the photos exist, and that they are large
// enough at `max_side`, the longest side of ingested photos (0 = as photographed). Throws Error{Usage} with the code GREY_CARD or
// SCALE_BAR. Returns a sentence on the pixels that count if a photo is reduced, else "".
std::string check_grey_card(const std::string& text, const fs::path& photos, int max_side = 0);
std::string check_scale_bar(const std::string& text, const fs::path& photos, int max_side = 0);

// Checks the measures of the settings. Returns the sentences on those of this command line.
std::vector<std::string> check_measures(const Settings& settings);

// Checks once, when the sfm stage is done and before later stages run, the measures of the chosen stages against the cameras.
// Throws as check_grey_card; also when the ends of a scale bar cannot be located.
class MeasuresOnce {
 public:
  MeasuresOnce(const Planner& planner, const Settings& settings, fs::path project);
  void operator()(size_t next);  // index of the next stage to be computed

 private:
  bool chosen(const char* stage) const;
  const Planner& planner_;
  const Settings& settings_;
  fs::path project_;
  bool done_ = false;
};

}  // namespace vitrine
