// The runs of a comparison with the programs of the stages, started one by one: only what the figures need.
//
// WORK/stages/<programs>/<scene>/  results of the stages before optimize; arms and seeds of a scene share those of equal keys
// WORK/given/<scene>/              the masks of the truth, in the folders that the stages read
// WORK/runs/<scene>/<arm>/seed_<n>/{store,eval,log.txt}  the training and its evaluation
// A folder of results is of one set of programs: a stage that was built anew without a new version has the same keys, and would
// be given results of the program before.
#pragma once

#include <map>
#include <memory>
#include <mutex>

#include "pipeline/settings.h"
#include "tests/bench/optics/arms.h"
#include "tests/bench/optics/protocol.h"
#include "tests/bench/optics/scenes.h"

namespace vitrine {

struct ProgramsDesc {
  fs::path programs, work;
  int steps = 1000, surfels = 30000, max_side = 320;
  bool relit = false;  // also mesh, refine and decompose, and the pictures under other lights
  int threads = 0;     // of a stage; 0 = all
};

class Programs {
 public:
  explicit Programs(ProgramsDesc desc);

  // Error{Usage}: an option of the arm that no stage has.
  OpticsRun run_of(const OpticsScene& scene, const Arm& arm, int training_seed);
  OpticsWork work();  // of runs that run_of made; refers to this object

 private:
  using Artifacts = std::map<std::string, fs::path>;  // stage -> its result
  struct Given {
    fs::path scene;
    std::string poses, masks;                                 // Arm::source()
    std::map<std::string, std::vector<std::string>> options;  // stage -> words of its command line
    std::mutex* preparing = nullptr;                          // of the scene
  };
  const Given& given(const OpticsRun& run) const { return given_.at({run.scene, run.arm, run.training_seed}); }
  bool is_training(const std::string& stage) const { return training_.contains(stage); }
  nlohmann::json train(const OpticsRun& run) const;
  Figures measure(const OpticsRun& run, const nlohmann::json& trained) const;
  fs::path run_stage(const StageNode& stage, const OpticsRun& run, const fs::path& store, const Artifacts& artifacts) const;
  fs::path masks_of(const OpticsRun& run) const;

  ProgramsDesc desc_;
  Graph graph_;
  std::vector<const StageNode*> stages_;                // that a run needs, in their order
  std::set<std::string> training_;                      // up to optimize
  std::map<std::string, std::string> program_digests_;  // of stages_
  std::string preparing_digest_;                        // of the programs before optimize
  std::map<std::tuple<std::string, std::string, int>, Given> given_;
  std::map<std::string, std::unique_ptr<std::mutex>> preparing_;
};

}  // namespace vitrine
