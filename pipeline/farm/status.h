// States of the tasks of a farm, read from their output folders: a table for the terminal, and RESULTS/index.html, worst first.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/farm/tasks.h"
#include "pipeline/report_page/figures.h"

namespace vitrine {

struct FarmState {
  FarmTask task;
  RunOutcome outcome;
  Verdict verdict;
  double seconds = 0;  // of the stages
  std::optional<double> psnr;

  bool done() const { return outcome.ending == Ending::Done; }
  std::string stage() const;   // reached: "mesh", "all", "-"
  std::string ending() const;  // "done", "exit 4", "stopped, goes on when run again", "not begun"
};

FarmState farm_state(const FarmTask& task);
std::string farm_table(const std::vector<FarmState>& states);
std::string farm_page(std::vector<FarmState> states, const fs::path& results);

}  // namespace vitrine
