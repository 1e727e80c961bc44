// Texts and calls of the engines that schedule a farm's tasks.
#pragma once

#include <string>
#include <vector>

#include "pipeline/farm/tasks.h"

namespace vitrine {

enum class FarmEngine { Slurm, Parallel };

// RESULTS/array.sbatch: one array job; a task that is stopped before its time limit writes its checkpoint, ends with 75 and is
// requeued.
std::string slurm_script(const fs::path& results, const std::vector<FarmTask>& tasks, int at_once);
// Hands the plan to the engine; returns its exit code. `at_once`: most tasks at a time; 0: the engine's choice, or with GNU
// parallel as many as this machine has cores for. Throws Error{Dependency} if the engine is not installed.
int submit_farm(const fs::path& results, const std::vector<FarmTask>& tasks, FarmEngine engine, int at_once);

}  // namespace vitrine
