// inspect: what a folder of photos promises before anything is computed from it, and, given an sfm artifact, where the cameras
// leave gaps. Started by `vitrine inspect`; it stands beside the graph of `vitrine run`, because nothing follows from it.
//   reads   the user's photos; optionally sfm/{sparse,scene.json}
//   writes  inspect/report.json
#pragma once

#include "stages/stage.h"

namespace vitrine {

struct InspectConfig {
  double soft_ratio = 1.7;
};
void describe(Describer& d, InspectConfig& c);

Stage inspect_stage();

}  // namespace vitrine
