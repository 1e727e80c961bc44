// What the stage says of passes between which an object was moved (passes.md), and sfm/passes.json.
#pragma once

#include <string>

#include "stages/sfm/object_poses.h"
#include "stages/stage.h"

namespace vitrine {

// `up`: the option, for the elevation of the cameras of `model`.
void report_passes(const ObjectPasses& passes, const ColmapModel& model, const std::string& up, StageContext& context);

}  // namespace vitrine
