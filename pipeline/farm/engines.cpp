#include "pipeline/farm/tasks.h"

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "pipeline/graph.h"

namespace vitrine {

namespace {

fs::path program(const char* name, const char* package) {
  const auto found = find_program(name);
  if (!found)
    throw Error(ErrorKind::Dependency, fmt::format("{} is not installed", name),
                {.why = "no folder of PATH has it",
                 .hint = fmt::format("apt-get install {}; or hand tasks.txt, one command a line, to another engine", package),
                 .code = "NO_ENGINE"});
  return *found;
}

// Without the variables that tie a child to this process: an engine hands its environment on to the tasks.
int submitted(const Words& words) {
  const ProcessResult result = run_process({.arguments = words, .inherit_output = true});
  return result.signal != 0 ? 128 + result.signal : result.exit_code;
}

}  // namespace

std::string slurm_script(const fs::path& results, const std::vector<FarmTask>& tasks, int at_once) {
  int cores = 1;
  size_t memory = kLeastTaskMemory;
  double hours = 0;
  for (const FarmTask& t : tasks) {
    cores = std::max(cores, t.cores);
    memory = std::max(memory, t.memory_bytes);
    hours = std::max(hours, t.hours);
  }
  const std::string farm =
      join_command({(own_folder() / "vitrine").string(), "farm", "task", results.string(), "--index", "auto"});
  std::string text = "#!/bin/bash\n#SBATCH --job-name=vitrine\n";
  text += fmt::format("#SBATCH --array=1-{}{}\n", tasks.size(), at_once > 0 ? fmt::format("%{}", at_once) : "");
  text += fmt::format("#SBATCH --cpus-per-task={}\n#SBATCH --mem={}M\n", cores, (memory + (size_t(1) << 20) - 1) >> 20);
  text += fmt::format("#SBATCH --time={}\n", std::max(int(std::ceil(60 * hours)), 10));  // minutes
  text += fmt::format("#SBATCH --output={}\n", (results / "logs" / "%a.log").string());
  text += "#SBATCH --open-mode=append\n#SBATCH --requeue\n#SBATCH --signal=B:TERM@120\n\n";
  text +=
      "# SIGTERM reaches this shell first: vitrine writes a checkpoint and ends with 75, and the task begins again where it "
      "stopped.\n";
  text += farm + " &\ntask=$!\ntrap 'kill -TERM \"$task\"' TERM\n";
  text += "code=0\nwait \"$task\" || code=$?\n";
  text += "while kill -0 \"$task\" 2>/dev/null; do code=0; wait \"$task\" || code=$?; done\n";
  text += "if [ \"$code\" -eq 75 ]; then scontrol requeue \"${SLURM_ARRAY_JOB_ID}_${SLURM_ARRAY_TASK_ID}\"; fi\nexit \"$code\"\n";
  return text;
}

int submit_farm(const fs::path& results, const std::vector<FarmTask>& tasks, FarmEngine engine, int at_once) {
  if (engine == FarmEngine::Slurm) {
    const fs::path sbatch = program("sbatch", "slurm-client"), script = results / "array.sbatch";
    make_folders(results / "logs");
    write_file(script, slurm_script(results, tasks, at_once));
    return submitted({sbatch.string(), script.string()});
  }
  int cores = 1;
  for (const FarmTask& t : tasks) cores = std::max(cores, t.cores);
  const int jobs = at_once > 0 ? at_once : std::max(1, hardware_threads() / cores);
  return submitted({program("parallel", "parallel").string(), "--will-cite", "--jobs", std::to_string(jobs), "--joblog",
                    (results / "joblog.tsv").string(), "--resume-failed", "--termseq", "TERM,120000,KILL,25", "--arg-file",
                    (results / "tasks.txt").string()});
}

}  // namespace vitrine
