// vitrine status | explain | cache: queries about an output folder.
#include <algorithm>
#include <iostream>
#include <map>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/config/cli.h"
#include "pipeline/commands.h"
#include "pipeline/plan.h"
#include "pipeline/project.h"

namespace vitrine {

namespace {

struct When {
  std::string started = "-", took = "-";
};

When timing_of(const fs::path& entry) {
  std::error_code ec;
  if (!fs::exists(entry / kTimingName, ec)) return {};
  const auto t = nlohmann::json::parse(read_file(entry / kTimingName), nullptr, false);
  if (!t.is_object()) return {};
  std::string started = t.value("started", "-").substr(0, 16);
  std::replace(started.begin(), started.end(), 'T', ' ');
  return {started, duration_text(t.value("seconds", 0.0))};
}

void explain_stage(const Step& step, const Settings& settings) {
  fmt::print("{} (version {}): {}\n", step.node->name, step.node->version,
             step.why.empty() ? std::string(name(step.state)) : fmt::format("{}: {}", name(step.state), step.why));
  if (step.key.empty()) return;
  fmt::print("  key {}\n", step.key);
  for (const auto& [term, value] : step.terms) {
    std::string note;
    if (term.starts_with("option.")) {
      const Option* o = settings.options.table.find(step.node->name + term.substr(6));
      if (o != nullptr && o->origin != "default") note = "  <- " + o->origin;
    }
    fmt::print("  {:<34} {}{}\n", term, value, note);
  }
}

std::string usage_tail() { return "PROJECT is the output folder of `vitrine run`; default: the current folder.\n"; }

}  // namespace

int status_command(const Words& words) {
  bool help = false;
  CommandLine cli("vitrine status", "[PROJECT]", "Which stages are up to date, and why the others are not.");
  cli.flag("help", 'h', help, "Print this text.");
  const Words rest = cli.parse(words, 1);
  if (help) {
    std::cout << cli.help(usage_tail());
    return 0;
  }
  const fs::path project = project_of(rest.empty() ? "." : rest[0]);
  const Graph graph = load_graph(stage_folder());
  Settings settings(graph);
  settings.load({.project = project});
  Planner planner(graph, settings, project, {});
  fmt::print("{:<10} {:<8} {:<16} {:<9} {:<8} {}\n", "stage", "state", "when (UTC)", "took", "key", "why");
  int to_run = 0;
  for (const Step& s : planner.all()) {
    to_run += to_be_run(s.state);
    const When when = s.manifest ? timing_of(planner.store().entry(s.node->name, s.key)) : When{};
    fmt::print("{:<10} {:<8} {:<16} {:<9} {:<8} {}\n", s.node->name, name(s.state), when.started, when.took,
               s.key.empty() ? "-" : s.key.substr(0, 7), s.state == StepState::Cached ? s.manifest->summary : s.why);
  }
  if (to_run == 0) fmt::print("everything up to date\n");
  return 0;
}

int explain_command(const Words& words) {
  bool help = false;
  CommandLine cli("vitrine explain", "[PROJECT] [STAGE]",
                  "What the next run would compute and which term of a key changed; with a stage: all that its key is made of.");
  cli.flag("help", 'h', help, "Print this text.");
  Words rest = cli.parse(words, 2);
  if (help) {
    std::cout << cli.help(usage_tail());
    return 0;
  }
  std::string word = ".";
  if (!rest.empty() && (rest.size() == 2 || is_project(rest[0]) || !is_project("."))) {
    word = rest[0];
    rest.erase(rest.begin());
  }
  const fs::path project = project_of(word);
  const Graph graph = load_graph(stage_folder());
  Settings settings(graph);
  settings.load({.project = project});
  Planner planner(graph, settings, project, {});
  const StageNode* only = rest.empty() ? nullptr : &graph.at(rest[0]);
  for (const Step& s : planner.all()) {
    if (only != nullptr) {
      if (s.node == only) explain_stage(s, settings);
      continue;
    }
    if (!to_be_run(s.state)) {
      fmt::print("{:<10} up to date\n", s.node->name);
      continue;
    }
    fmt::print("{:<10} runs because {}\n", s.node->name,
               s.state == StepState::Stale && !s.changes.empty() ? s.changes[0] : s.why);
    for (size_t i = 1; i < s.changes.size(); ++i) fmt::print("{:<10}          and {}\n", "", s.changes[i]);
  }
  return 0;
}

int cache_command(const Words& words) {
  bool help = false;
  CommandLine cli(
      "vitrine cache", "du|prune [PROJECT]",
      "du: what the store of an output folder holds. prune: remove every artifact that is not the current one of its stage.");
  cli.flag("help", 'h', help, "Print this text.");
  const Words rest = cli.parse(words, 2);
  if (help) {
    std::cout << cli.help(usage_tail());
    return 0;
  }
  if (rest.empty() || (rest[0] != "du" && rest[0] != "prune"))
    throw Error(ErrorKind::Usage, "du or prune?", {.hint = "vitrine cache du PROJECT", .code = "USAGE"});
  const fs::path project = project_of(rest.size() > 1 ? rest[1] : ".");
  ArtifactStore store(store_of(project));
  const auto current = current_keys(project);
  const auto is_current = [&](const ArtifactStore::Entry& e) {
    for (const char* role : {"", "-edited"})
      if (const auto found = current.find(e.stage + role); found != current.end() && found->second == e.key) return true;
    return false;
  };
  size_t total = 0, freed = 0;
  if (rest[0] == "du") {
    for (const auto& e : store.entries()) {
      total += e.bytes;
      fmt::print("{:<10} {:<9} {:>10}  {}\n", e.stage, e.key.substr(0, 7), bytes_text(e.bytes),
                 !e.committed    ? "unfinished"
                 : is_current(e) ? "current"
                                 : "");
    }
    fmt::print("{:<10} {:<9} {:>10}\n", "all", "", bytes_text(total));
    return 0;
  }
  const ProjectLock lock(project);
  for (const auto& e : store.entries()) {
    if (is_current(e)) continue;
    freed += e.bytes;
    std::error_code ec;
    if (e.committed)
      store.remove(e.stage, e.key);
    else
      fs::remove_all(e.path, ec);
    if (ec) throw_write_error(e.path, ec.value());
  }
  fmt::print("{} removed\n", bytes_text(freed));
  return 0;
}

}  // namespace vitrine
