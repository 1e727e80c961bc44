// mark: one HTML file with the photos, in which people annotate glass and metal, and which saves marks.yaml (README). Started by
// `vitrine mark`; not part of the graph of `vitrine run`.
//   reads   the user's photos; optionally a file of marks, and of a run sfm (cameras) and masks (propagated marks)
//   writes  mark.html
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct MarkConfig {
  int photo_side = 1600;
  int megapixels = 120;
  std::string command = "vitrine run PHOTOS -o OUT --masks marks.yaml";
};
void describe(Describer& d, MarkConfig& c);

// `page`: HTML without photos (stages/page_text.h).
void write_mark(const std::string& page, const MarkConfig& config, StageContext& context);
void run_mark(const MarkConfig& config, StageContext& context);
Stage mark_stage();

}  // namespace vitrine
