// Carries a plan out: stage by stage as a child process, artifacts linked into the output folder as they are finished.
#pragma once

#include <functional>
#include "pipeline/plan.h"

#include "pipeline/report.h"

namespace vitrine {

struct RunnerDesc {
  int threads = 0;          // 0 = all
  std::string memory = {};  // as given: "4GiB"
  bool verbose = false, quiet = false;
  // Called before each stage that is computed, with its number in the graph.
  std::function<void(size_t)> before_computing = {};
};

// Returns the number of stages that had to be computed. Throws the Error of the first stage that fails.
int run_stages(Planner& planner, const Settings& settings, const fs::path& project, Report& report, const RunnerDesc& desc);

}  // namespace vitrine
