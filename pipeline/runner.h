// Executes a plan: each stage as a child process; artifacts are linked into the output folder when finished.
#pragma once

#include <functional>
#include "pipeline/plan.h"

#include "pipeline/report.h"

namespace vitrine {

struct RunnerDesc {
  int threads = 0;          // 0 = all
  std::string memory = {};  // as given: "4GiB"
  bool verbose = false, quiet = false;
  // Called before each computed stage with its index in the graph.
  std::function<void(size_t)> before_computing = {};
};

// Returns the number of computed stages. Throws the Error of the first stage that fails.
int run_stages(Planner& planner, const Settings& settings, const fs::path& project, Report& report, const RunnerDesc& desc);

}  // namespace vitrine
