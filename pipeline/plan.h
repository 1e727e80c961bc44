// What a run would do and why, found out without computing anything: each stage is asked for its cache key (`--print-key`), as
// far as its inputs exist; the key's terms are compared with those of the stage's last artifact to say in words what changed.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/artifact/store.h"
#include "core/base/process.h"
#include "pipeline/settings.h"

namespace vitrine {

enum class StepState {
  Cached,   // the artifact is there with all its bytes
  Kept,     // outside the chosen range: the current artifact is used as it is
  Stale,    // there is an older artifact, made from other terms
  Missing,  // never computed
  Damaged,  // computed, but its files are not what they were
  Forced,   // --force
  Waiting,  // an input is going to be computed first
  Skipped,  // outside the chosen range
};
std::string_view name(StepState state);
inline bool to_be_run(StepState s) { return s != StepState::Cached && s != StepState::Kept && s != StepState::Skipped; }

struct Step {
  const StageNode* node = nullptr;
  StepState state = StepState::Missing;
  std::string why = {};                   // one line; for Stale the first changes
  std::vector<std::string> changes = {};  // all changed terms, in words
  std::string key = {};                   // empty while Waiting
  KeyTerms terms = {};
  std::optional<Manifest> manifest = {};  // of the artifact, when there is a usable one
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
  // One stage, given the steps of all stages before it.
  Step step(const StageNode& node, const std::vector<Step>& before);
  std::vector<Step> all();
  // `--input NAME=PATH` words; nullopt while an input is not there yet.
  std::optional<std::vector<std::string>> inputs(const StageNode& node, const std::vector<Step>& before) const;
  bool chosen(const StageNode& node) const { return chosen_.contains(node.name); }
  bool forced(const StageNode& node) const { return selection_.force && chosen_.contains(node.name); }

 private:
  void ask_key(const StageNode& node, const std::vector<std::string>& inputs, Step& step) const;
  const Graph& graph_;
  const Settings& settings_;
  fs::path project_;
  Selection selection_;
  std::set<std::string> chosen_, needed_;  // brought up to date; used as they are
  ArtifactStore store_;
};

// A stage that ended badly, as the Error it reported (`error_record`, a line of --log-format json), or, when it had no time to
// report, as what its signal or exit code tells.
[[noreturn]] void throw_stage_failure(const StageNode& node, const std::string& error_record, const ProcessResult& result);

}  // namespace vitrine
