// What the stages of a run will take, as each says itself (`vitrine-<stage> --cost`, core/artifact/stage_cost.h).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/artifact/stage_cost.h"
#include "pipeline/graph.h"
#include "pipeline/settings.h"

namespace vitrine {

// Fills in the size of a typical photo: that of the one in the middle. `sides`: shorter and longer of each photo, not empty.
void take_typical_size(std::vector<std::pair<double, double>> sides, CaptureSize& capture);
// Whether a run with these settings is given masks.
bool gives_masks(const Settings& settings);

CostTerms cost_terms(const Settings& settings, const CaptureSize& capture, int threads);

struct CostAnswer {
  std::vector<StageCost> costs;  // one for each of the terms, or none
  std::string problem;           // why there are none: "its program does not answer --cost"
};
// From one start of the stage's program. A program that is missing, fails or reads an option of a stage that this pipeline does
// not have is no error: the stage has no estimate.
CostAnswer stage_costs(const StageNode& stage, const std::vector<CostTerms>& terms);

}  // namespace vitrine
