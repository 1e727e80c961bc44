// Runs of a comparison: what is done is kept, one JSON file a run, and what was made with other settings is not mixed with it.
//
// WORK/runs/<scene>/<arm>/seed_<n>.json has the settings of the training (`training`), what it left (`trained`), the settings of
// the measurement (`measuring`) and `figures`. It is written after the training and again after the measurement. A file with
// other settings of the training ends the program: the table would compare what cannot be compared. Other settings of the
// measurement (another vitrine-evaluate) measure again.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "tests/bench/optics/figures.h"

namespace vitrine {

struct OpticsRun {
  std::string scene, arm;
  int training_seed = 1;
  nlohmann::json training, measuring;  // everything that the figures depend on

  std::string name() const;  // "seed_7 full seed 1"
};

struct OpticsResult {
  std::string scene, arm;
  int training_seed = 1;
  Figures figures;
};

struct OpticsWork {
  // The answer is kept and given to `measure`. A member "cpu_s" is a figure.
  std::function<nlohmann::json(const OpticsRun&)> train;
  std::function<Figures(const OpticsRun&, const nlohmann::json& trained)> measure;
};

struct OpticsOutcome {
  std::vector<OpticsResult> results;  // in the order of the runs
  std::vector<std::string> failures;  // runs that failed, with what they said; the others are done all the same
};

fs::path file_of_run(const fs::path& work, const OpticsRun& run);
fs::path folder_of_run(const fs::path& work, const OpticsRun& run);  // what the run leaves beside its file

// Runs what is not done, `jobs` at a time; `say` gets a line for each. Error{Usage} before anything is run when a file was made
// with other settings. Error{Interrupted} or {Preempted} when asked to stop.
OpticsOutcome run_optics(const std::vector<OpticsRun>& runs, const fs::path& work, int jobs, const OpticsWork& what,
                         const std::function<void(const std::string&)>& say);

}  // namespace vitrine
