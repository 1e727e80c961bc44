// The stage contract. A stage = declaration + typed config + run(). `stage_main` owns the command line, the cache key, the
// temporary folder, the log, the commit and the exit code, so that a stage's own code is only the science of the stage, and
// its main.cpp is a formality:
//
//   int main(int argc, char** argv) { return vitrine::stage_main(vitrine::mesh_stage(), argc, argv); }
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/artifact/stage_cost.h"
#include "core/artifact/stage_report.h"
#include "core/config/describe.h"

namespace vitrine {

// What a stage reads. An input is another stage's artifact, or a folder of the user's (photos, truth).
struct StageInput {
  std::string name;      // "sfm", "optimize", "photos", "truth": also the command-line word --input NAME=PATH
  bool artifact = true;  // false: an outside folder or file, digested by content
  bool optional = false;
  std::string doc;
  std::vector<std::string> skips = {};  // of an outside input: files with these extensions are for other stages (".yaml")
  // What a path means that stands for more than itself: one file of a COLMAP model for the whole, which then is in the key.
  std::filesystem::path (*meant)(const std::filesystem::path&) = nullptr;
};

struct StageInfo {
  std::string name;     // "mesh"
  int version = 1;      // bump when the output changes for the same inputs (history: tests/golden/stage_versions.md)
  std::string summary;  // one line, for help and reports
  std::vector<StageInput> inputs;
  std::string doing = {};                         // the same for people who do not know its name: "finding the camera poses"
  StageCost (*cost)(const CostTerms&) = nullptr;  // what it will take
  StageReport report = {};                        // what report.html says of its results
};

struct Progress {                        // one report of a running stage
  double fraction = 0;                   // of the stage, in [0, 1]
  std::string text;                      // "step 1200/3000  loss 0.0312  41k surfels"
  std::map<std::string, double> values;  // for events.jsonl: {"step":1200,"loss":0.0312}
};

// What stage_main hands to run().
class StageContext {
 public:
  virtual ~StageContext() = default;
  // Folder of an input; throws Error{Usage} when a required one is missing. nullopt only for optional ones.
  virtual std::filesystem::path input(std::string_view name) const = 0;
  virtual std::optional<std::filesystem::path> optional_input(std::string_view name) const = 0;
  // Where to write: a temporary folder that becomes the artifact when run() returns, and vanishes when it throws.
  virtual const std::filesystem::path& output() const = 0;
  // Survives interruption and kill -9 of the same key; removed after the commit. For checkpoints and partial downloads.
  virtual const std::filesystem::path& scratch() const = 0;
  virtual int threads() const = 0;
  virtual size_t max_memory_bytes() const = 0;   // 0 = no limit given
  virtual void progress(const Progress& p) = 0;  // bar or plain line, and events.jsonl; call as often as you like
  // A figure that belongs in the manifest, the events and the one-line summary of the run ("registered", 47).
  virtual void metric(std::string_view name, double value) = 0;
  virtual void warning(std::string_view code, std::string_view text) = 0;  // shown, logged, kept in the manifest
  virtual void summary(std::string_view text) = 0;                         // what the pipeline prints behind the stage's name
  // The work up to `fraction` is in scratch() and survives: told in events.jsonl.
  virtual void checkpoint([[maybe_unused]] double fraction) {}
  // A figure of the machine or the clock: logged and in events.jsonl, never in the artifact (artifacts are reproducible).
  virtual void timing(std::string_view name, double seconds) = 0;
};

struct Stage {
  StageInfo info;
  std::shared_ptr<void> config;  // the typed config object
  OptionTable options;           // over *config
  std::function<void(StageContext&)> run;
  std::function<std::string()> problem;                              // cross-field rule: empty = fine, else the sentence
  std::function<std::map<std::string, std::string>()> fingerprints;  // external tools, numerics: {"colmap": "3.8"}
};

template <class Config>
Stage make_stage(StageInfo info, void (*run)(const Config&, StageContext&),
                 std::function<std::map<std::string, std::string>()> fingerprints = {},
                 std::string (*problem)(const Config&) = nullptr) {
  auto config = std::make_shared<Config>();
  Stage s;
  s.info = std::move(info);
  s.options = options_of(*config);
  s.run = [config, run](StageContext& context) { run(*config, context); };
  s.problem = [config, problem] { return problem ? problem(*config) : std::string(); };
  s.fingerprints = std::move(fingerprints);
  s.config = config;
  return s;
}

int stage_main(Stage stage, int argc, char** argv);

}  // namespace vitrine
