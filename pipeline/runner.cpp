#include "pipeline/plan.h"
#include "pipeline/report.h"

#include <unistd.h>

#include "core/foundation/artifact/publish.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

void run_stage(Planner& planner, const Step& step, const std::vector<Step>& before, const Settings& settings, Report& report,
               const fs::path& project, const RunnerDesc& desc) {
  const StageNode& node = *step.node;
  std::vector<std::string> words = {
      node.executable.string(),      "--store", planner.store().root().string(), "--log-format", "json", "--log-file",
      (project / "log.txt").string()};
  const auto inputs = planner.inputs(node, before);
  VITRINE_CHECK(inputs.has_value(), "stage '{}' started before its inputs are there", node.name);
  words.insert(words.end(), inputs->begin(), inputs->end());
  const std::vector<std::string> options = settings.stage_arguments(node);
  words.insert(words.end(), options.begin(), options.end());
  if (planner.forced(node)) words.push_back("--force");
  if (desc.threads > 0) words.insert(words.end(), {"--threads", std::to_string(desc.threads)});
  if (!desc.memory.empty()) words.insert(words.end(), {"--max-memory", desc.memory});
  if (desc.verbose) words.push_back("--verbose");
  if (desc.quiet) words.push_back("--quiet");
  const ProcessResult result = run_process({.arguments = words,
                                            .environment = {{"VITRINE_PARENT_PID", std::to_string(getpid())}},
                                            .on_line = [&](std::string_view line) { report.stage_line(line); }});
  if (result.ok()) return;
  if (report.error_record().empty()) throw_if_interrupted();
  throw_stage_failure(node, report.error_record(), result);
}

}  // namespace

int run_stages(Planner& planner, const Settings& settings, const fs::path& project, Report& report, const RunnerDesc& desc) {
  std::vector<Step> steps;
  int computed = 0;
  const size_t count = planner.graph().nodes.size();
  for (const StageNode& node : planner.graph().nodes) {
    throw_if_interrupted();
    // Planned again before each stage: a recomputed stage may give the same bytes, and then the stages after it are up to date.
    Step step = planner.step(node, steps);
    if (step.state == StepState::Skipped) {
      steps.push_back(std::move(step));
      continue;
    }
    report.stage_begins(steps.size() + 1, count, step);
    const StepState how = step.state;
    if (to_be_run(how)) {
      try {
        if (desc.before_computing) desc.before_computing(steps.size());
        run_stage(planner, step, steps, settings, report, project, desc);
      } catch (const Error& e) {
        report.stage_failed(e);
        throw;
      }
      step.manifest = planner.store().find(node.name, step.key);
      VITRINE_CHECK(step.manifest.has_value(), "stage '{}' ended well but left no artifact {}", node.name, step.key);
      step.state = StepState::Cached;
      ++computed;
    }
    std::optional<Manifest> before;
    const auto current = current_key(project, node.name);
    if (current && *current != step.key && fs::exists(planner.store().entry(node.name, *current) / kManifestName))
      before = planner.store().find(node.name, *current);
    const fs::path entry = planner.store().entry(node.name, step.key);
    if (node.name == kExportStage) {
      const auto kept = publish_export(entry, *step.manifest, project, before ? &*before : nullptr);
      if (!kept.empty())
        report.line(fmt::format("note: export/ keeps what `vitrine export` wrote ({}); deleted files are written by the next run",
                                fmt::join(kept, ", ")));
    } else {
      publish(entry, *step.manifest, project, before ? &*before : nullptr);
    }
    set_current_key(project, node.name, step.key);
    report.stage_ends(*step.manifest, how);
    steps.push_back(std::move(step));
  }
  return computed;
}

}  // namespace vitrine
