#include "pipeline/report_page/outcome.h"

#include <algorithm>

#include <fmt/format.h>

#include "core/foundation/artifact/publish.h"
#include "core/foundation/base/folder_files.h"
#include "pipeline/report_page/facts.h"

namespace vitrine {

namespace {

constexpr int kInterrupted = 130, kPreempted = 75;

// Events of the last run, from its run_start.
std::vector<Facts> last_events(const fs::path& project) {
  const std::string text = text_of_file(project / "events.jsonl");
  size_t begin = text.rfind("\"type\":\"run_start\"");
  if (begin == std::string::npos) return {};
  begin = text.rfind('\n', begin);
  begin = begin == std::string::npos ? 0 : begin + 1;
  std::vector<Facts> events;
  while (begin < text.size()) {
    const size_t end = std::min(text.find('\n', begin), text.size());
    // Progress events are most of the file and unused here.
    if (const std::string line = text.substr(begin, end - begin); line.find("\"type\":\"progress\"") == std::string::npos)
      if (const Facts event = Facts::of_text(line); event.known()) events.push_back(event);
    begin = end + 1;
  }
  return events;
}

// Exit status, 0 to 255.
int exit_of(const Facts& end) { return int(std::min(end.amount("exit").value_or(0), 255.0)); }

StageOutcome cost_of(const Facts& stage) {
  StageOutcome cost{.name = stage.text("name"), .state = stage.text("state"), .summary = stage.text("summary")};
  if (cost.name.empty()) cost.name = stage.text("stage");  // event record
  cost.seconds = stage.amount("seconds");
  cost.cpu_seconds = stage.amount("cpu_seconds");
  cost.peak_bytes = stage.amount("peak_rss_bytes");
  for (const Facts& warning : stage.at("warnings").items()) cost.warnings.push_back(warning.text());
  return cost;
}

void read_events(const std::vector<Facts>& events, RunOutcome& o, std::map<std::string, std::string>& keys, bool with_stages) {
  for (const Facts& e : events) {
    const std::string type = e.text("type"), stage = e.text("stage");
    if (type == "run_start") o.version = e.text("version");
    if (type == "run_end") o.exit = exit_of(e), o.finished = e.text("time");
    if (type == "error") o.failure = StageFailure{stage, e.text("code"), e.text("message"), e.text("why"), e.text("hint")};
    if (type == "stage_start") keys[stage] = e.text("key");
    if (!with_stages) continue;
    if (type == "stage_start" && !o.stage(stage)) o.stages.push_back({.name = stage, .state = "running"});
    if (type == "stage_end")
      for (StageOutcome& s : o.stages)
        if (s.name == stage) s = cost_of(e), s.state = "ran";
  }
}

// Cached stages cost nothing in this run: shows the cost of their computation.
void add_stored_costs(const fs::path& project, const std::map<std::string, std::string>& current, RunOutcome& o) {
  for (StageOutcome& s : o.stages) {
    const auto key = current.find(s.name);
    if (s.state == "ran" || s.state == "failed" || s.state == "running" || key == current.end() || !stays_below(key->second))
      continue;
    const Facts timing = Facts::of_file(store_of(project) / s.name / key->second / "timing.json");
    s.seconds = timing.amount("seconds");
    s.cpu_seconds = timing.amount("cpu_seconds");
    s.peak_bytes = timing.amount("peak_rss_bytes");
  }
}

}  // namespace

const StageOutcome* RunOutcome::stage(std::string_view name) const {
  const auto found = std::find_if(stages.begin(), stages.end(), [&](const StageOutcome& s) { return s.name == name; });
  return found == stages.end() ? nullptr : &*found;
}

bool RunOutcome::has(std::string_view name) const {
  const StageOutcome* s = stage(name);
  return s != nullptr && s->state != "failed" && s->state != "running";
}

std::string RunOutcome::last_stage() const {
  if (failure && !failure->stage.empty()) return failure->stage;
  for (const StageOutcome& s : stages)
    if (s.state == "failed" || s.state == "running") return s.name;
  return {};
}

fs::path RunOutcome::report_of(const fs::path& project, const std::string& stage, const fs::path& file) const {
  const auto attempt = attempts.find(stage);
  std::error_code ec;
  if (attempt != attempts.end() && fs::exists(attempt->second / file.filename(), ec)) return attempt->second / file.filename();
  return project / file;
}

RunOutcome read_outcome(const fs::path& project) {
  RunOutcome o;
  const Facts run = Facts::of_file(project / "run.json");
  const std::vector<Facts> events = last_events(project);
  const bool ended =
      events.empty() || std::any_of(events.begin(), events.end(), [](const Facts& e) { return e.text("type") == "run_end"; });
  std::map<std::string, std::string> keys;
  read_events(events, o, keys, !ended || !run.known());
  const auto option = [&](std::string_view name) { return run.at("options").member(name).text("value"); };
  o.preset = option("preset");
  o.photos = option("input.photos");
  o.masks = option("input.masks");
  if (run.known() && ended) {
    for (const Facts& s : run.at("stages").items()) o.stages.push_back(cost_of(s));
    o.exit = exit_of(run);
    o.version = run.text("vitrine");
    o.finished = run.text("finished");
    if (const auto threads = run.amount("machine.threads"))
      o.machine = fmt::format("{:.0f} thread{}", *threads, *threads == 1 ? "" : "s");
  }
  const auto current = current_keys(project);
  add_stored_costs(project, current, o);
  o.ending = !run.known() && events.empty()                   ? Ending::Unknown
             : !ended                                         ? Ending::CutOff
             : o.exit == 0                                    ? Ending::Done
             : o.exit == kInterrupted || o.exit == kPreempted ? Ending::Stopped
                                                              : Ending::Failed;
  if (o.ending != Ending::Failed) o.failure.reset();

  for (const auto& [stage, key] : keys)
    if (!o.has(stage) && stays_below(key)) o.attempts[stage] = store_of(project) / stage / (key + ".scratch");
  return o;
}

}  // namespace vitrine
