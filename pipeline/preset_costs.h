// What a run of a capture would cost, for every preset: the estimates of `vitrine inspect`.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/foundation/base/json.h"
#include "pipeline/cost_model.h"

namespace vitrine {

struct PresetCost {
  std::string preset;
  std::vector<std::pair<std::string, std::optional<StageCost>>> stages;
  std::vector<std::string> unknown;  // stages without an estimate, with the reason
  double seconds = 0;
  size_t memory = 0, disk = 0;
};

struct CostInputs {
  fs::path photos;
  std::string truth = {};  // input.truth of the run
};
// Sorted by time. `threads`: of the run.
std::vector<PresetCost> preset_costs(const Graph& graph, const CostInputs& inputs, const CaptureSize& capture, int threads);
nlohmann::ordered_json costs_json(const std::vector<PresetCost>& costs, int threads);

}  // namespace vitrine
