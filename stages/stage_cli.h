// The command line of every stage executable.
#pragma once

#include <string>
#include <vector>

#include "core/foundation/config/cli.h"
#include "stages/stage.h"

namespace vitrine {

struct StageArguments {
  std::vector<std::string> inputs;  // NAME=PATH
  std::string output, store;
  std::vector<std::string> configs, sets, sets_from;
  int threads = 0;
  std::string max_memory;
  std::string cost;
  bool force = false, print_key = false, describe = false, help = false, version = false;
  std::string events, log_file, log_format = "text";
  bool no_progress = false, quiet = false, verbose = false;
};

StageArguments parse_stage_arguments(const StageInfo& info, const std::vector<std::string>& words);
std::string stage_help(const StageInfo& info, const OptionTable& options);
// Output of `--describe`: one JSON object with everything the pipeline needs to know about a stage.
std::string stage_description(const StageInfo& info, const OptionTable& options);
// Output of `--cost`. Throws Error{Usage} if the stage has no estimate, or if the file lacks an option the estimate reads.
std::string stage_cost_answer(const StageInfo& info, const std::string& file);
// Config files in order, then --set-from, then --set. A file is a map of the stage's options, or of stages (then this stage's
// part is read).
void apply_stage_config(const StageArguments& arguments, const StageInfo& info, OptionTable& options);

}  // namespace vitrine
