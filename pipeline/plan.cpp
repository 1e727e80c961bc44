#include "pipeline/plan.h"

#include <algorithm>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/config/text.h"
#include "pipeline/graph.h"

namespace vitrine {

using nlohmann::json;

std::string_view name(StepState state) {
  switch (state) {
    case StepState::Cached:
      return "cached";
    case StepState::Kept:
      return "kept";
    case StepState::Stale:
      return "stale";
    case StepState::Missing:
      return "missing";
    case StepState::Damaged:
      return "damaged";
    case StepState::Forced:
      return "forced";
    case StepState::Waiting:
      return "stale";
    case StepState::Skipped:
      return "skipped";
  }
  return "missing";
}

namespace {

std::optional<ErrorKind> kind_of_exit(int code) {
  for (ErrorKind kind : {ErrorKind::Internal, ErrorKind::Usage, ErrorKind::Input, ErrorKind::SfmFailed, ErrorKind::QualityGate,
                         ErrorKind::Resource, ErrorKind::Dependency, ErrorKind::Device, ErrorKind::Locked, ErrorKind::Diverged,
                         ErrorKind::Preempted, ErrorKind::Interrupted, ErrorKind::Terminated})
    if (exit_code(kind) == code) return kind;
  return std::nullopt;
}

}  // namespace

void throw_stage_failure(const StageNode& node, const std::string& error_record, const ProcessResult& result) {
  const json record = json::parse(error_record, nullptr, false);
  if (record.is_object()) {
    const ErrorKind kind = kind_of_exit(record.value("exit", 1)).value_or(ErrorKind::Internal);
    throw Error(kind, record.value("message", "failed"),
                {.where = record.value("where", ""),
                 .why = record.value("why", ""),
                 .hint = record.value("hint", ""),
                 .code = record.value("code", "")});
  }
  if (result.signal != 0) throw_ended_by_signal(node.name, result);
  throw Error(kind_of_exit(result.exit_code).value_or(ErrorKind::Internal),
              fmt::format("stage '{}' ended with code {} and no word", node.name, result.exit_code),
              {.why = result.tail,
               .hint = "this is a bug in vitrine: please report it with run.json and log.txt",
               .code = "STAGE_CRASHED"});
}

Planner::Planner(const Graph& graph, const Settings& settings, fs::path project, const Selection& selection)
    : graph_(graph), settings_(settings), project_(std::move(project)), selection_(selection), store_(store_of(project_)) {
  if (!selection_.only.empty()) {
    if (!selection_.from.empty() || !selection_.to.empty())
      throw Error(ErrorKind::Usage, "--only cannot be used with --from or --to",
                  {.hint = "--only STAGE is --from STAGE --to STAGE", .code = "USAGE"});
    selection_.from = selection_.to = selection_.only;
  }
  for (const StageNode& n : graph_.nodes) chosen_.insert(n.name);
  if (!selection_.to.empty()) {
    const StageNode& to = graph_.at(selection_.to);
    chosen_ = graph_.ancestors(to);
    chosen_.insert(to.name);
  }
  if (!selection_.from.empty()) {
    const StageNode& from = graph_.at(selection_.from);
    std::set<std::string> after = graph_.descendants(from);
    after.insert(from.name);
    std::erase_if(chosen_, [&](const std::string& s) { return !after.contains(s); });
    if (chosen_.empty())
      throw Error(ErrorKind::Usage, fmt::format("nothing lies between --from {} and --to {}", selection_.from, selection_.to),
                  {.hint = "`vitrine status` lists the stages in their order", .code = "USAGE"});
  }
  for (const std::string& s : chosen_) needed_.merge(graph_.ancestors(graph_.at(s)));
}

void Planner::request_key(const StageNode& node, const std::vector<std::string>& inputs, Step& step) const {
  std::vector<std::string> words = {node.executable.string(), "--print-key", "--log-format", "json", "--store",
                                    store_.root().string()};
  words.insert(words.end(), inputs.begin(), inputs.end());
  const std::vector<std::string> options = settings_.stage_arguments(node);
  words.insert(words.end(), options.begin(), options.end());
  // A memory limit may lower options of a stage, which changes its key.
  if (const std::string memory = settings_.text("limits.memory"); !memory.empty())
    words.insert(words.end(), {"--max-memory", memory});
  std::string text, error_record;
  const ProcessResult r = run_process({.arguments = words, .on_line = [&](std::string_view line) {
                                         if (line.starts_with("{\"v\""))
                                           error_record = std::string(line);
                                         else
                                           text += std::string(line) + "\n";
                                       }});
  throw_if_interrupted();
  const auto answer = printed_key(text);
  if (!r.ok() || !answer) throw_stage_failure(node, error_record, r);
  step.key = answer->key;
  step.terms = answer->terms;
}

std::optional<std::vector<std::string>> Planner::inputs(const StageNode& node, const std::vector<Step>& before) const {
  std::vector<std::string> words;
  for (const NodeInput& input : node.inputs) {
    if (input.artifact) {
      const auto step = std::find_if(before.begin(), before.end(), [&](const Step& s) { return s.node->name == input.name; });
      VITRINE_CHECK(step != before.end(), "stage '{}' planned before its input '{}'", node.name, input.name);
      if (!step->manifest || to_be_run(step->state)) return std::nullopt;
      words.insert(words.end(), {"--input", input.name + "=" + store_.entry(input.name, step->manifest->key).string()});
      continue;
    }
    const std::string path = settings_.text("input." + input.name);
    if (path.empty() || path == "none") {
      if (input.optional) continue;
      throw Error(ErrorKind::Usage, fmt::format("stage '{}' needs '{}' and none are given", node.name, input.name),
                  {.why = input.doc, .hint = fmt::format("--set input.{}=PATH", input.name), .code = "MISSING_INPUT"});
    }
    const std::string extension = lower_extension(path);
    if (std::find(input.skips.begin(), input.skips.end(), extension) != input.skips.end()) continue;
    words.insert(words.end(), {"--input", input.name + "=" + path});
  }
  return words;
}

Step Planner::step(const StageNode& node, const std::vector<Step>& before) {
  Step step{.node = &node};
  const std::optional<std::string> current = current_key(project_, node.name);
  std::optional<Manifest> last;
  if (current && fs::exists(store_.entry(node.name, *current) / kManifestName)) {
    try {
      last = store_.find(node.name, *current);
    } catch (const Error&) {
      // Unreadable: reported as damage below if it is the required one.
    }
  }
  if (!chosen_.contains(node.name)) {
    step.state = needed_.contains(node.name) ? StepState::Kept : StepState::Skipped;
    step.why = "outside the chosen range";
    if (step.state == StepState::Skipped) return step;
    if (!last || !store_.damage(store_.entry(node.name, *current)).empty())
      throw Error(ErrorKind::Usage, fmt::format("there is no finished '{}' to start from", node.name),
                  {.where = project_.string(),
                   .hint = "leave out --from and --only: what is missing is computed first",
                   .code = "NOTHING_TO_START_FROM"});
    step.key = *current;
    step.terms = last->terms;
    step.manifest = last;
    return step;
  }
  const auto words = inputs(node, before);
  if (!words) {
    step.state = StepState::Waiting;
    std::vector<std::string> causes;
    for (const NodeInput& input : node.inputs)
      for (const Step& s : before)
        if (input.artifact && s.node->name == input.name && (to_be_run(s.state) || !s.manifest)) causes.push_back(input.name);
    step.why = fmt::format("needs {}", fmt::join(causes, " and "));
    return step;
  }
  request_key(node, *words, step);
  const fs::path entry = store_.entry(node.name, step.key);
  if (forced(node)) {
    step.state = StepState::Forced;
    step.why = "--force";
    return step;
  }
  if (fs::exists(entry / kManifestName)) {
    const std::string damage = store_.damage(entry);
    if (damage.empty()) {
      step.state = StepState::Cached;
      step.manifest = store_.find(node.name, step.key);
      return step;
    }
    step.state = StepState::Damaged;
    step.why = damage;
    return step;
  }
  if (!last) {
    step.state = StepState::Missing;
    step.why = fs::exists(store_.scratch(node.name, step.key)) ? "was interrupted; continues" : "not computed yet";
    return step;
  }
  step.state = StepState::Stale;
  step.changes = changed_terms(last->terms, step.terms);
  step.why = step.changes.empty() ? "its artifact is gone" : step.changes[0];
  if (step.changes.size() > 1) step.why += fmt::format(" and {} more", step.changes.size() - 1);
  return step;
}

std::vector<Step> Planner::all() {
  std::vector<Step> steps;
  for (const StageNode& node : graph_.nodes) steps.push_back(step(node, steps));
  return steps;
}

}  // namespace vitrine
