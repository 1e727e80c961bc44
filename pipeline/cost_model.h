// Cost estimates of the stages of a run, from `vitrine-<stage> --cost` (core/foundation/artifact/stage_cost.h), and the check
// against the available resources.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/foundation/artifact/stage_cost.h"
#include "core/foundation/base/json.h"
#include "pipeline/graph.h"
#include "pipeline/settings.h"

namespace vitrine {

// Usual error factor of the estimates (README.md, "What a run costs").
inline constexpr double kUsualCostError = 1.3;
// Texture of a capture before it is measured; inspect measures 0.3 to 0.6 in ordinary photos.
inline constexpr double kUsualTexture = 0.4;

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

// The ingested photos; nullopt before ingest.
std::optional<CaptureSize> ingested_capture(const fs::path& project, const Settings& settings);

struct Resources {
  size_t memory_bytes = 0, disk_bytes = 0;
  bool memory_is_limit = false;  // memory_bytes is --max-memory, not the free memory
};

// Check before the long stages, once the photo sizes are known: estimated time, memory and disk of the remaining run against the
// available ones. A clearly insufficient disk ends the run. Memory and time are only reported: a stage that exceeds its memory
// stops by itself (stages/reporter.h).
struct Preflight {
  double seconds = 0;
  size_t memory_bytes = 0, disk_bytes = 0;
  std::string hungriest;             // the stage that needs memory_bytes
  std::vector<std::string> unknown;  // stages without an estimate, with the reason: "mesh (it declares no estimate)"
  std::vector<std::string> notes;
};

// Throws Error{Resource} if the disk is too small even when the estimate is too high by its usual error.
Preflight preflight(const std::vector<const StageNode*>& stages, const Settings& settings, const CaptureSize& capture,
                    int threads, const Resources& there);
std::string preflight_line(const Preflight& p, const Resources& there);

// The sums for every preset, for `vitrine inspect` (preset_costs.cpp).

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
