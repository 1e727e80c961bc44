// The task table of a farm: one run of `vitrine` a capture, for engines that schedule (Slurm, GNU parallel, array jobs of
// clouds). RESULTS/tasks.tsv is the table, RESULTS/tasks.txt has the same commands, one a line. A task is restartable: the same
// command goes on where a run was stopped.
#pragma once

#include <string>
#include <vector>

#include "core/foundation/base/file.h"
#include "pipeline/commands.h"

namespace vitrine {

// No task gets less: `mesh` refuses a limit below twice its fusion.memory_mb, whatever the scene needs.
inline constexpr size_t kLeastTaskMemory = size_t(2) << 30;

struct FarmTask {
  std::string capture;     // name of its folder
  fs::path photos;         // a folder of photos or films
  fs::path project = {};   // RESULTS/<capture>
  size_t photo_count = 0;  // files, before films are cut
  int cores = 1;
  size_t memory_bytes = 0;  // 0: no estimate
  double hours = 0;         // 0: no estimate
  Words options = {};       // of `vitrine run`
};

struct FarmPlanDesc {
  std::vector<fs::path> captures;  // folders whose sub-folders are captures
  fs::path results;
  int cores = 4;  // of a task
  Words options;  // of `vitrine run`, for all tasks
};
struct FarmPlan {
  std::vector<FarmTask> tasks;     // sorted by name
  std::vector<std::string> notes;  // what was left out, and why
};
// A capture is a sub-folder with photos, or one with a folder `photos`, next to which marks.yaml or masks may lie. Throws
// Error{Input}: no capture; two of one name; Error{Usage}: options that `vitrine run` refuses, RESULTS inside a capture.
FarmPlan plan_farm(const FarmPlanDesc& desc);

// The words of `vitrine run` of a task.
Words run_words(const FarmTask& task);

fs::path tasks_path(const fs::path& results);
void write_tasks(const fs::path& results, const std::vector<FarmTask>& tasks);
// Throws Error{Input} with file and line.
std::vector<FarmTask> read_tasks(const fs::path& results);

// Index of this process in an array job, from 0, by the variable of the engine. Throws Error{Usage} if there is none, or two
// differ.
size_t array_index();
// Cores and bytes of memory that the engine gave this task; 0: not known.
int given_cores();
size_t given_memory();

// Texts and calls of the engines that schedule the tasks (engines.cpp).

enum class FarmEngine { Slurm, Parallel };

// RESULTS/array.sbatch: one array job; a task that is stopped before its time limit writes its checkpoint, ends with 75 and is
// requeued.
std::string slurm_script(const fs::path& results, const std::vector<FarmTask>& tasks, int at_once);
// Hands the plan to the engine; returns its exit code. `at_once`: most tasks at a time; 0: the engine's choice, or with GNU
// parallel as many as this machine has cores for. Throws Error{Dependency} if the engine is not installed.
int submit_farm(const fs::path& results, const std::vector<FarmTask>& tasks, FarmEngine engine, int at_once);

}  // namespace vitrine
