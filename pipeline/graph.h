// The stage graph, read from files next to the executable: `vitrine.stages` lists the names; `vitrine-<name> --describe` prints
// inputs, version and options. The pipeline neither links nor names a stage.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/artifact/manifest.h"
#include "core/foundation/artifact/stage_report.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"

namespace vitrine {

struct NodeInput {
  std::string name;
  bool artifact = true, optional = false;
  std::string doc;
  std::vector<std::string> skips;  // ignored file extensions; those files belong to other stages
};

struct StageNode {
  std::string name, summary;
  int version = 1;
  fs::path executable;
  std::vector<NodeInput> inputs;
  std::string description;           // JSON of --describe, with the options
  std::string doing;                 // description for messages
  StageReport report;                // figures and facts for report.html
  bool has_cost = false;             // supports --cost
  std::vector<std::string> devices;  // words of --device that this build has; empty: no --device
};

class Graph {
 public:
  std::vector<StageNode> nodes;  // in topological order

  // Error{Usage} with a suggestion.
  const StageNode& at(std::string_view name) const;
  std::set<std::string> ancestors(const StageNode& node) const;    // without itself
  std::set<std::string> descendants(const StageNode& node) const;  // without itself
  // Names of external inputs (photos, truth), in order of first use.
  std::vector<NodeInput> outside_inputs() const;
};

// Whether a stage was built with kernels for a GPU.
bool has_device_kernels(const Graph& graph);
// The reason for which the stages cannot compute on a GPU; empty: they can.
std::string why_no_device(const Graph& graph);

// Throws an error for a stage program that a signal ended (result.signal != 0).
[[noreturn]] void throw_ended_by_signal(std::string_view stage, const ProcessResult& result);

// $VITRINE_STAGE_DIR, or the folder of this executable.
fs::path stage_folder();
fs::path own_folder();
Graph load_graph(const fs::path& folder);

// Output of --print-key.
struct PrintedKey {
  std::string key;
  KeyTerms terms;
};
// nullopt if `output` contains no key. Other output, from libraries, may precede or follow it.
std::optional<PrintedKey> printed_key(std::string_view output);

// Key of the command `words` (program and arguments); empty if the program fails, which is reported when it is run.
std::string key_of_run(std::vector<std::string> words);

}  // namespace vitrine
