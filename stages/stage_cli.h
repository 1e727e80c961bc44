// The command line of every stage executable, and the inputs it names.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "core/foundation/artifact/store.h"
#include "core/foundation/config/cli.h"
#include "stages/stage.h"

namespace vitrine {

struct StageArguments {
  std::vector<std::string> inputs;  // NAME=PATH
  std::string output, store;
  std::vector<std::string> configs, sets, sets_from;
  int threads = 0;
  std::string max_memory, device = "cpu";
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

// Inputs of one run of a stage: paths and content digests.

struct ResolvedInput {
  fs::path path;
  std::string content_digest;
};

// `words` are NAME=PATH. The path of an artifact may be an entry of a store (a folder with manifest.json), an output folder of
// `vitrine run` (its current artifact of that stage is used), or any folder with the right files. Throws Error{Input} or
// Error{Usage} for damaged, missing or unknown inputs.
std::map<std::string, ResolvedInput> resolve_inputs(const StageInfo& info, const std::vector<std::string>& words,
                                                    DigestCache& digests);

}  // namespace vitrine
