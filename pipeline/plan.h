// Plans a run without computing: queries the cache key of each stage whose inputs exist (`--print-key`), and compares its terms
// with those of the stage's last artifact to report what changed.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/foundation/artifact/store.h"
#include "core/foundation/base/process.h"
#include "pipeline/settings.h"

namespace vitrine {

class Report;

enum class StepState {
  Cached,   // the artifact is complete and intact
  Kept,     // outside the chosen range: the current artifact is used unchanged
  Stale,    // an artifact with other key terms exists
  Missing,  // never computed
  Damaged,  // files of the artifact have changed
  Forced,   // --force
  Waiting,  // an input must be computed first
  Skipped,  // outside the chosen range
};
std::string_view name(StepState state);
inline bool to_be_run(StepState s) { return s != StepState::Cached && s != StepState::Kept && s != StepState::Skipped; }

struct Step {
  const StageNode* node = nullptr;
  StepState state = StepState::Missing;
  std::string why = {};                   // one line; for Stale the first changes
  std::vector<std::string> changes = {};  // all changed terms as text
  std::string key = {};                   // empty while Waiting
  KeyTerms terms = {};
  std::optional<Manifest> manifest = {};  // of the usable artifact, if any
};

struct Selection {
  std::string from, to, only;
  bool force = false;
};

class Planner {
 public:
  Planner(const Graph& graph, const Settings& settings, fs::path project, const Selection& selection);

  const Graph& graph() const { return graph_; }
  ArtifactStore& store() { return store_; }
  // Plans one stage; `before`: steps of all earlier stages.
  Step step(const StageNode& node, const std::vector<Step>& before);
  std::vector<Step> all();
  // `--input NAME=PATH` words; nullopt while an input is missing.
  std::optional<std::vector<std::string>> inputs(const StageNode& node, const std::vector<Step>& before) const;
  bool chosen(const StageNode& node) const { return chosen_.contains(node.name); }
  bool forced(const StageNode& node) const { return selection_.force && chosen_.contains(node.name); }

 private:
  void request_key(const StageNode& node, const std::vector<std::string>& inputs, Step& step) const;
  const Graph& graph_;
  const Settings& settings_;
  fs::path project_;
  Selection selection_;
  std::set<std::string> chosen_, needed_;  // stages to bring up to date; stages used unchanged
  ArtifactStore store_;
};

// Throws the Error that a failed stage reported (`error_record`, a line of --log-format json), or an error from its signal or
// exit code if it reported none.
[[noreturn]] void throw_stage_failure(const StageNode& node, const std::string& error_record, const ProcessResult& result);

// Executes a plan: each stage as a child process; artifacts are linked into the output folder when finished.

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
