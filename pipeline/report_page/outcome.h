// Outcome of the last run in a folder: its end, cost and warnings of each stage. Read from run.json if the run wrote it,
// otherwise (killed or still running) from events.jsonl; costs of cached stages come from the store.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"

namespace vitrine {

enum class Ending {
  Done,     // exit 0
  Failed,   // a stage or the run reported an error
  Stopped,  // Ctrl-C, SIGTERM
  CutOff,   // no recorded end: killed, or still running
  Unknown,  // no record of a run
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
  std::vector<StageOutcome> stages;                      // in order of execution
  std::optional<StageFailure> failure;
  std::map<std::string, fs::path> attempts;  // working folders of stages without a result

  const StageOutcome* stage(std::string_view name) const;
  bool has(std::string_view name) const;  // true if the stage has a finished result
  std::string last_stage() const;         // the stage that failed or was running
  // Path of a stage's report: in its working folder if there is one, otherwise `file` in the output folder.
  fs::path report_of(const fs::path& project, const std::string& stage, const fs::path& file) const;
};

RunOutcome read_outcome(const fs::path& project);

}  // namespace vitrine
