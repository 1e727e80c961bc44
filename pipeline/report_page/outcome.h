// What happened: how the last run of the folder ended, what each stage cost, what it warned of. From run.json when the run wrote
// it, else (killed, or still at work) from events.jsonl; a stage that was not computed anew has its costs in the store.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/base/file.h"

namespace vitrine {

enum class Ending {
  Done,     // exit 0
  Failed,   // a stage or the run reported an error
  Stopped,  // asked to: Ctrl-C, SIGTERM
  CutOff,   // no word of an end: killed, or still at work
  Unknown,  // no trace of a run
};

struct StageOutcome {
  std::string name = {}, state = {}, summary = {};  // state: ran, cached, kept, failed, running
  std::optional<double> seconds = {}, cpu_seconds = {}, peak_bytes = {};
  std::vector<std::string> warnings = {};
};

struct StageFailure {
  std::string stage, code, message, why, hint;
};

struct RunOutcome {
  Ending ending = Ending::Unknown;
  int exit = 0;
  std::string version, preset, photos, masks, finished;  // options and UTC time of the run
  std::string machine;                                   // "2 threads"
  std::vector<StageOutcome> stages;                      // in order
  std::optional<StageFailure> failure;
  std::map<std::string, fs::path> attempts;  // stages without a result: the folder in which they worked

  const StageOutcome* stage(std::string_view name) const;
  bool has(std::string_view name) const;  // there is a finished result of this stage
  std::string last_stage() const;         // the one that failed, or that was under way
  // A report of the stage, in the folder of an attempt where it has left one, else `file` of the output folder.
  fs::path report_of(const fs::path& project, const std::string& stage, const fs::path& file) const;
};

RunOutcome read_outcome(const fs::path& project);

}  // namespace vitrine
