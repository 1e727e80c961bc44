// vitrine-farm: many captures on engines that exist. Started by `vitrine farm`.
#include <algorithm>
#include <charconv>
#include <cstring>
#include <iostream>

#include <unistd.h>

#include "core/foundation/base/error.h"
#include "core/foundation/config/cli.h"
#include "pipeline/farm/status.h"
#include "pipeline/graph.h"

namespace {

using namespace vitrine;

struct FarmArguments {
  std::string output, index, engine;
  int cores = 4, at_once = 0;
  bool help = false;
};

CommandLine command_line(FarmArguments& a) {
  CommandLine cli(
      "vitrine farm", "plan|submit|task|status FOLDER... [options]",
      "Many captures: one run of vitrine each, scheduled by an engine that is there. plan: writes RESULTS/tasks.tsv and "
      "tasks.txt, a task for every folder of photos in FOLDER, -o RESULTS; what follows `--` are options of vitrine run. submit: "
      "hands "
      "them to an engine. task: runs one of them. status: how far they are; writes RESULTS/index.html.");
  cli.section("plan");
  cli.value("output", 'o', "RESULTS", a.output, "Folder of the results, one output folder a capture.");
  cli.value("cores", 0, "N", a.cores, 1, "Cores of a task; default 4.");
  cli.section("submit");
  cli.value("engine", 0, "slurm|parallel", a.engine, "Slurm (an array job), or GNU parallel on this machine.");
  cli.value("at-once", 0, "N", a.at_once, 1, "Most tasks at a time.");
  cli.section("task");
  cli.value("index", 0, "N|auto", a.index,
            "Number of the task, from 1; auto: from the engine's array variable (Slurm, Grid Engine, PBS, LSF, AWS Batch, "
            "Kubernetes, GNU parallel).");
  cli.flag("help", 'h', a.help, "Print this text.");
  return cli;
}

Error usage(const std::string& what, const char* hint) { return {ErrorKind::Usage, what, {.hint = hint, .code = "USAGE"}}; }

int plan(const std::vector<std::string>& folders, const Words& options, const FarmArguments& a) {
  if (folders.empty()) throw usage("which captures?", "vitrine farm plan CAPTURES -o RESULTS");
  if (a.output.empty()) throw usage("where to?", "vitrine farm plan CAPTURES -o RESULTS");
  FarmPlanDesc desc{.captures = {}, .results = fs::absolute(a.output).lexically_normal(), .cores = a.cores, .options = options};
  for (const std::string& folder : folders) desc.captures.push_back(fs::absolute(folder).lexically_normal());
  const FarmPlan plan = plan_farm(desc);
  write_tasks(desc.results, plan.tasks);
  for (const std::string& note : plan.notes) fmt::print("note: {}\n", note);
  double hours = 0, longest = 0;
  size_t memory = 0;
  for (const FarmTask& t : plan.tasks)
    hours += t.hours, longest = std::max(longest, t.hours), memory = std::max(memory, t.memory_bytes);
  fmt::print("{} {}: about {:.1f} h in all, {:.1f} h the longest, with {} cores and up to {} MiB each\n{}\n", plan.tasks.size(),
             plan.tasks.size() == 1 ? "task" : "tasks", hours, longest, a.cores, memory >> 20, tasks_path(desc.results).string());
  return 0;
}

int run_task(const fs::path& results, const FarmArguments& a) {
  std::vector<FarmTask> tasks = read_tasks(results);
  size_t index = 0;
  if (a.index.empty() || a.index == "auto") {
    index = array_index();
  } else {
    const auto [end, error] = std::from_chars(a.index.data(), a.index.data() + a.index.size(), index);
    if (error != std::errc() || *end != 0 || index == 0)
      throw usage(fmt::format("'{}' is no number of a task", a.index), "--index 1, or --index auto");
    --index;
  }
  if (index >= tasks.size())
    throw usage(fmt::format("there is no task {}", index + 1), fmt::format("the plan has {}", tasks.size()).c_str());
  FarmTask task = tasks[index];
  if (const int cores = given_cores(); cores > 0) task.cores = cores;
  if (const size_t memory = given_memory(); memory > 0) task.memory_bytes = memory;
  // In place of this process: signals of the engine reach the run.
  Words words = run_words(task);
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::cout.flush();
  execv(arguments[0], arguments.data());
  throw Error(ErrorKind::Dependency, "vitrine cannot be started",
              {.where = words[0], .why = std::strerror(errno), .hint = "install or build all of vitrine", .code = "NO_PROGRAM"});
}

int show_status(const fs::path& results) {
  std::vector<FarmState> states;
  for (const FarmTask& task : read_tasks(results)) states.push_back(farm_state(task));
  fmt::print("{}", farm_table(states));
  write_file(results / "index.html", farm_page(states, results));
  fmt::print("{}\n", (results / "index.html").string());
  return 0;
}

int submit(const fs::path& results, const FarmArguments& a) {
  if (a.engine != "slurm" && a.engine != "parallel") throw usage("which engine?", "--engine slurm, or --engine parallel");
  return submit_farm(results, read_tasks(results), a.engine == "slurm" ? FarmEngine::Slurm : FarmEngine::Parallel, a.at_once);
}

int farm(Words words) {
  FarmArguments a;
  const CommandLine cli = command_line(a);
  Words options;
  if (const auto dashes = std::ranges::find(words, "--"); dashes != words.end()) {
    options.assign(dashes + 1, words.end());
    words.erase(dashes, words.end());
  }
  const Words rest = cli.parse(words);
  if (a.help) {
    std::cout << cli.help();
    return 0;
  }
  const std::string what = rest.empty() ? "" : rest[0];
  if (what == "plan") return plan({rest.begin() + 1, rest.end()}, options, a);
  if (what != "submit" && what != "task" && what != "status") throw usage("plan, submit, task or status?", "vitrine farm --help");
  if (!options.empty())
    throw usage("options of vitrine run belong to the plan", "vitrine farm plan CAPTURES -o RESULTS -- OPTIONS");
  if (rest.size() != 2) throw usage("which results?", "the folder that vitrine farm plan wrote");
  const fs::path results = fs::absolute(rest[1]).lexically_normal();
  return what == "submit" ? submit(results, a) : what == "task" ? run_task(results, a) : show_status(results);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return farm({argv + 1, argv + argc});
  } catch (const vitrine::Error& e) {
    std::cout.flush();
    fmt::print(stderr, "{}\n", e.with_prefix());
    return vitrine::exit_code(e.kind());
  } catch (const std::exception& e) {
    fmt::print(stderr, "error: {}\n", e.what());
    return vitrine::exit_code(vitrine::ErrorKind::Internal);
  }
}
