// The stages and how they feed each other. All of it is learned from the executables beside `vitrine`: the file `vitrine.stages`
// lists their names, `vitrine-<name> --describe` prints inputs, version and options. No stage is linked, none is named here.
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/artifact/stage_report.h"
#include "core/base/file.h"
#include "core/base/process.h"

namespace vitrine {

struct NodeInput {
  std::string name;
  bool artifact = true, optional = false;
  std::string doc;
  std::vector<std::string> skips;  // files with these extensions are for other stages
};

struct StageNode {
  std::string name, summary;
  int version = 1;
  fs::path executable;
  std::vector<NodeInput> inputs;
  std::string description;  // the JSON of --describe: its options are read from it
  std::string doing;        // what it is about, for people who do not know its name
  StageReport report;       // what report.html says of its results
  bool has_cost = false;    // it answers --cost
};

class Graph {
 public:
  std::vector<StageNode> nodes;  // every stage after those it reads from

  // Error{Usage} with a suggestion.
  const StageNode& at(std::string_view name) const;
  std::set<std::string> ancestors(const StageNode& node) const;    // without itself
  std::set<std::string> descendants(const StageNode& node) const;  // without itself
  // Names of inputs that come from outside (photos, truth), in order of first use.
  std::vector<NodeInput> outside_inputs() const;
};

// Tells of a stage's program that a signal ended (result.signal != 0).
[[noreturn]] void throw_ended_by_signal(std::string_view stage, const ProcessResult& result);

// $VITRINE_STAGE_DIR, else the folder of this executable.
fs::path stage_folder();
fs::path own_folder();
Graph load_graph(const fs::path& folder);

}  // namespace vitrine
