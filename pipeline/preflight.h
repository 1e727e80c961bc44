// Before the long stages begin, once the photos are read and their sizes known: what the rest of the run will take of time,
// memory and disk (cost_model), against what there is. A disk that is clearly too small ends the run here, not after hours;
// memory and time are told, for a stage that takes too much stops by itself (stages/memory_watch.h).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/cost_model.h"
#include "pipeline/graph.h"

namespace vitrine {

// The photos as ingest left them. nullopt: they are not read yet.
std::optional<CaptureSize> ingested_capture(const fs::path& project, const Settings& settings);

struct Resources {
  size_t memory_bytes = 0, disk_bytes = 0;
  bool memory_is_limit = false;  // memory_bytes is --max-memory, not what the machine has left
};

struct Preflight {
  double seconds = 0;
  size_t memory_bytes = 0, disk_bytes = 0;
  std::string hungriest;             // the stage that takes memory_bytes
  std::vector<std::string> unknown;  // stages without an estimate, and why: "mesh (it declares no estimate)"
  std::vector<std::string> notes;
};

// Error{Resource} when the disk cannot hold the results, even if the estimate is too high by as much as estimates are.
Preflight preflight(const std::vector<const StageNode*>& stages, const Settings& settings, const CaptureSize& capture,
                    int threads, const Resources& there);
std::string preflight_line(const Preflight& p, const Resources& there);

}  // namespace vitrine
