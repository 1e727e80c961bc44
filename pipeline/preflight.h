// Check before the long stages, once the photo sizes are known: estimated time, memory and disk of the remaining run (cost_model)
// against the available ones. A clearly insufficient disk ends the run. Memory and time are only reported: a stage that exceeds
// its memory stops by itself (stages/memory_watch.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/cost_model.h"
#include "pipeline/graph.h"

namespace vitrine {

// The ingested photos; nullopt before ingest.
std::optional<CaptureSize> ingested_capture(const fs::path& project, const Settings& settings);

struct Resources {
  size_t memory_bytes = 0, disk_bytes = 0;
  bool memory_is_limit = false;  // memory_bytes is --max-memory, not the free memory
};

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

}  // namespace vitrine
