// The stage contract. A stage = declaration + typed config + run(). `stage_main` handles command line, cache key, temporary
// folder, log, commit and exit code, so that a stage contains only its algorithm. The
// build generates its main() from stages/program.cpp.in.
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

#include "core/foundation/artifact/stage_cost.h"
#include "core/foundation/artifact/stage_report.h"
#include "core/foundation/base/graphics_card.h"
#include "core/foundation/config/describe.h"

namespace vitrine {

// An input of a stage: the artifact of another stage, or a folder of the user (photos, truth).
struct StageInput {
  std::string name;      // "sfm", "optimize", "photos", "truth"; also the NAME in --input NAME=PATH
  bool artifact = true;  // false: an external folder or file, digested by content
  bool optional = false;
  std::string doc;
  std::vector<std::string> skips = {};  // external inputs: ignored file extensions (".yaml"); those files belong to other stages
  // Expands a path, for example one file of a COLMAP model to the whole model, which then enters the key.
  std::filesystem::path (*meant)(const std::filesystem::path&) = nullptr;
  // External inputs: files that a given file refers to and that the stage reads with it; their content enters the key, too.
  std::vector<std::filesystem::path> (*also)(const std::filesystem::path&) = nullptr;
};

struct StageInfo {
  std::string name;     // "mesh"
  int version = 1;      // increase when the output changes for the same inputs (history: tests/golden/stage_versions.md)
  std::string summary;  // one line, for help and reports
  std::vector<StageInput> inputs;
  std::string doing = {};                         // description for messages: "finding the camera poses"
  StageCost (*cost)(const CostTerms&) = nullptr;  // cost estimate
  StageReport report = {};                        // figures and facts for report.html
  DeviceUse device = {};                          // not empty: it has --device; its fingerprints name the numerics
};

struct Progress {                        // progress report of a running stage
  double fraction = 0;                   // of the stage, in [0, 1]
  std::string text;                      // "step 1200/3000  loss 0.0312  41k surfels"
  std::map<std::string, double> values;  // for events.jsonl: {"step":1200,"loss":0.0312}
};

// Interface of stage_main for run().
class StageContext {
 public:
  virtual ~StageContext() = default;
  // Folder of an input. Throws Error{Usage} when a required input is missing; nullopt for a missing optional one.
  virtual std::filesystem::path input(std::string_view name) const = 0;
  virtual std::optional<std::filesystem::path> optional_input(std::string_view name) const = 0;
  // Output folder: temporary; becomes the artifact when run() returns, is deleted when it throws.
  virtual const std::filesystem::path& output() const = 0;
  // For checkpoints and partial downloads. Survives interruption and kill -9 for the same key; removed after the commit.
  virtual const std::filesystem::path& scratch() const = 0;
  virtual int threads() const = 0;
  virtual size_t max_memory_bytes() const = 0;   // 0: no limit
  virtual void progress(const Progress& p) = 0;  // progress bar or text line, and events.jsonl; may be called at any rate
  // A figure for the manifest, the events and the one-line summary of the run ("registered", 47).
  virtual void metric(std::string_view name, double value) = 0;
  virtual void warning(std::string_view code, std::string_view text) = 0;  // printed, logged, stored in the manifest
  virtual void summary(std::string_view text) = 0;                         // printed by the pipeline after the stage's name
  // The work up to `fraction` is saved in scratch(); recorded in events.jsonl.
  virtual void checkpoint([[maybe_unused]] double fraction) {}
  // A time measurement: logged and recorded in events.jsonl, never in the artifact (artifacts are reproducible).
  virtual void timing(std::string_view name, double seconds) = 0;
};

// Options that a stage lowers to stay within --max-memory. The decision precedes the cache key and uses the names and sizes of
// the inputs: the key then covers the lowered options, and a run with more memory does not reuse the reduced result.
using InputPaths = std::map<std::string, std::filesystem::path>;  // given inputs by name

struct FittedOption {
  std::string path, value;  // option and its new value
  std::string code, text;   // of the warning
};
struct Stage;
using StageFit = std::function<std::vector<FittedOption>(const Stage& stage, size_t max_memory_bytes, const InputPaths& inputs)>;

struct Stage {
  StageInfo info;
  std::shared_ptr<void> config;  // the typed config object
  OptionTable options;           // options of *config
  std::function<void(StageContext&)> run;
  std::function<std::string()> problem;                              // cross-field check; returns an error sentence, or empty
  std::function<std::map<std::string, std::string>()> fingerprints;  // versions of external tools, numerics: {"colmap": "3.8"}
  StageFit fit = {};                                                 // empty: nothing to lower
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
