// inspect: quality of a photo set before any computation, and, given an sfm artifact, gaps between the cameras. Started by
// `vitrine inspect`; not part of the graph of `vitrine run`.
//   reads   the user's photos; optionally sfm/{sparse,scene.json}
//   writes  inspect/report.json
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct InspectConfig {
  double soft_ratio = 1.7;
  int frames = 120;  // as ingest.frames
};
void describe(Describer& d, InspectConfig& c);

Stage inspect_stage();

}  // namespace vitrine
