// Cost estimates of the stages of a run, from `vitrine-<stage> --cost` (core/foundation/artifact/stage_cost.h).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/foundation/artifact/stage_cost.h"
#include "pipeline/graph.h"
#include "pipeline/settings.h"

namespace vitrine {

// Sets the size of a typical photo: the median one. `sides`: shorter and longer side of each photo, not empty.
void take_typical_size(std::vector<std::pair<double, double>> sides, CaptureSize& capture);
// True if a run with these settings gets masks from the user.
bool gives_masks(const Settings& settings);

CostTerms cost_terms(const Settings& settings, const CaptureSize& capture, int threads);

struct CostAnswer {
  std::vector<StageCost> costs;  // one per element of the terms, or empty
  std::string problem;           // reason for missing costs: "its program does not answer --cost"
};
// Starts the stage's program once. If the program is missing, fails, or reads an option of a stage that is not in this pipeline,
// the stage has no estimate; no error is thrown.
CostAnswer stage_costs(const StageNode& stage, const std::vector<CostTerms>& terms);

}  // namespace vitrine
