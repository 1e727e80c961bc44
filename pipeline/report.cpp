#include "pipeline/report.h"

#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <ctime>

#include "core/foundation/base/json.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/terminal.h"
#include "core/foundation/base/timer.h"
#include "core/foundation/config/schema.h"
#include "core/foundation/config/text.h"

namespace vitrine {

using Json = nlohmann::ordered_json;

namespace {

constexpr int kRunFormat = 1;
constexpr double kLinePeriod = 10;  // seconds between plain progress lines
constexpr size_t kReportColumns = 80;

std::string coloured(std::string_view text, const char* code) {
  return colour_wanted(1) ? fmt::format("\033[{}m{}\033[0m", code, text) : std::string(text);
}

std::string coloured_head(const std::string& lines, std::string_view head, const char* code) {
  const size_t at = lines.find(head);
  if (at == std::string::npos) return lines;
  return lines.substr(0, at) + coloured(head, code) + lines.substr(at + head.size());
}

// Pads by displayed columns, not bytes: summaries contain names in any script.
std::string padded(std::string_view text, size_t width) {
  std::string cut = cut_to_columns(text, width);
  size_t columns = 0;
  for (char c : cut) columns += (static_cast<unsigned char>(c) & 0xc0) != 0x80;
  return cut + std::string(width - columns, ' ');
}

// Indents a message of a running stage and wraps it to 80 columns.
std::string stage_note(std::string_view text) {
  constexpr size_t kIndent = 7, kDeeper = 9;
  std::string lines;
  for (const std::string& part : wrapped(text, kReportColumns - kDeeper))
    lines += fmt::format("{}{:{}}{}", lines.empty() ? "" : "\n", "", lines.empty() ? kIndent : kDeeper, part);
  return lines;
}

// Error fields of the run itself; stages write their own name.
Json error_fields(const Error& error) {
  const ErrorDetail& d = error.detail();
  return {{"stage", "run"},
          {"kind", name(error.kind())},
          {"exit", exit_code(error.kind())},
          {"code", d.code.empty() ? "FAILED" : d.code},
          {"message", error.message()},
          {"where", d.where},
          {"why", d.why},
          {"hint", d.hint}};
}

std::string line_of(std::string_view type, const Json& fields) {
  Json out = {{"v", kEventsVersion}, {"type", type}, {"time", utc_now()}};
  out.update(fields);
  return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

std::string early_error_record(const Error& error) { return line_of("error", error_fields(error)); }

std::string utc_now() {
  const auto now = std::chrono::system_clock::now();
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &utc);
  return text;
}

void Report::open() {
  started_ = utc_now();
  events_.open(desc_.project / "events.jsonl", std::ios::app);
  log_.open(desc_.project / "log.txt", std::ios::app);
  if (!events_ || !log_)
    throw Error(ErrorKind::Resource, "cannot write into the output folder",
                {.where = desc_.project.string(), .hint = "choose a folder you can write to with -o", .code = "NOT_WRITABLE"});
  record("run_start", {{"version", VITRINE_VERSION}, {"command", desc_.command}, {"project", desc_.project.string()}});
}

void Report::log(std::string_view text) {
  if (log_.is_open()) log_ << text << '\n' << std::flush;
}

void Report::line(std::string_view text) {
  log(text);
  console(text);
}

void Report::note(std::string_view text) {
  log(text);
  console(stage_note(text));
}

void Report::console(std::string_view text) const {
  if (desc_.json || desc_.quiet) return;
  clear_status_line();
  fmt::print("{}\n", text);
  std::fflush(stdout);
}

void Report::record(std::string_view type, Json fields) {
  const std::string text = line_of(type, fields);
  if (events_.is_open()) events_ << text << '\n' << std::flush;
  if (desc_.json) {
    fmt::print("{}\n", text);
    std::fflush(stdout);
  }
}

std::string Report::prefix() const {
  return fmt::format("[{}/{}] {:<10}", number_, count_, stages_.empty() ? "" : stages_.back().name);
}

void Report::stage_begins(size_t number, size_t count, const Step& step) {
  number_ = number;
  count_ = count;
  error_record_.clear();
  last_line_s_ = clock_.seconds();
  StageRecord r;
  r.name = step.node->name;
  r.version = step.node->version;
  r.state = "running";
  r.why = step.why;
  r.key = step.key;
  stages_.push_back(std::move(r));
  record("plan", {{"stage", step.node->name}, {"state", name(step.state)}, {"why", step.why}, {"key", step.key}});
  if (!to_be_run(step.state)) return;
  if (!desc_.json && !desc_.quiet && desc_.show_progress) draw_status_line(fmt::format("{} {}", prefix(), step.why));
}

void Report::stage_line(std::string_view text) {
  const nlohmann::json event = text.starts_with("{\"v\"") ? nlohmann::json::parse(text, nullptr, false) : nlohmann::json();
  if (!event.is_object() || !event.contains("type")) {
    note(text);
    return;
  }
  if (events_.is_open()) events_ << text << '\n' << std::flush;
  if (desc_.json) {
    fmt::print("{}\n", text);
    std::fflush(stdout);
  }
  const std::string type = event.at("type");
  StageRecord& r = stages_.back();
  if (type == "progress") {
    progress(event);
  } else if (type == "warning") {
    r.warnings.push_back(event.value("text", ""));
    const std::string text = "warning: " + event.value("text", "");
    log(text);
    console(coloured_head(stage_note(text), "warning:", "33"));
  } else if (type == "error") {
    error_record_ = std::string(text);
  } else if (type == "stage_end") {
    r.seconds = event.value("seconds", 0.0);
    r.cpu_seconds = event.value("cpu_seconds", 0.0);
    r.peak_rss_bytes = event.value("peak_rss_bytes", size_t{0});
    r.key = event.value("key", "");
  }
}

void Report::progress(const nlohmann::json& event) {
  if (desc_.json || desc_.quiet || !desc_.show_progress) return;
  const double fraction = event.value("fraction", nlohmann::json(0.0)).is_number() ? event["fraction"].get<double>() : 0.0;
  const std::string eta = event.contains("eta_s") && event["eta_s"].is_number()
                              ? "  ETA " + duration_text(event["eta_s"].get<double>())
                              : std::string();
  const std::string text = event.value("text", "");
  if (is_terminal(2)) {
    draw_status_line(fmt::format("{} {} {:3.0f} %{}  {}", prefix(), bar_text(fraction, 12), 100 * fraction, eta, text));
  } else if (clock_.seconds() - last_line_s_ >= kLinePeriod) {
    last_line_s_ = clock_.seconds();
    fmt::print("{}\n", cut_to_columns(fmt::format("{} {:3.0f} %{}  {}", prefix(), 100 * fraction, eta, text), kReportColumns));
    std::fflush(stdout);
  }
}

void Report::stage_ends(const Manifest& manifest, StepState how) {
  StageRecord& r = stages_.back();
  const bool computed = to_be_run(how);
  r.state = computed ? "ran" : std::string(name(how));
  r.key = manifest.key;
  r.content_digest = manifest.content_digest;
  r.summary = manifest.summary;
  r.metrics = manifest.metrics;
  r.warnings.clear();
  for (const ManifestWarning& w : manifest.warnings) r.warnings.push_back(w.text);
  for (const auto& [term, value] : manifest.terms) {
    if (term.starts_with("input.")) r.inputs[term.substr(6)] = value;
    if (term.starts_with("tool.")) r.tools[term.substr(5)] = value;
  }
  const std::string time = computed ? duration_text(r.seconds) : "";
  // A long summary continues on the next line.
  const size_t width = kReportColumns - (prefix().size() + 1 + 12 + 8);
  const std::vector<std::string> parts = wrapped(manifest.summary, width);
  line(fmt::format("{} {}{:>11}   {}", prefix(), padded(parts.empty() ? "" : parts[0], width), time,
                   !computed                   ? std::string(name(how))
                   : manifest.warnings.empty() ? coloured("ok", "32")
                                               : coloured("warned", "33")));
  for (size_t i = 1; i < parts.size(); ++i) line(fmt::format("{:{}} {}", "", prefix().size(), parts[i]));
}

void Report::stage_failed(const Error& error) {
  stages_.back().state = "failed";
  clear_status_line();
  line(fmt::format("{} {}  {}", prefix(), coloured("FAILED", "31"), error.detail().code));
  if (log_.is_open()) log_ << error.with_prefix() << '\n' << std::flush;
}

void Report::untold_error(const Error& error) {
  if (error_record_.empty()) record("error", error_fields(error));
}

void Report::finish(const Settings& settings, int exit_code) {
  record("run_end", {{"ok", exit_code == 0}, {"exit", exit_code}, {"seconds", clock_.seconds()}});
  char host[128] = "";
  gethostname(host, sizeof host - 1);
  Json run = {{"format", kRunFormat},
              {"vitrine", VITRINE_VERSION},
              {"command", desc_.command},
              {"started", started_},
              {"finished", utc_now()},
              {"seconds", clock_.seconds()},
              {"exit", exit_code},
              {"machine", {{"host", host}, {"threads", hardware_threads()}, {"memory_bytes", machine_memory_bytes()}}}};
  size_t peak = 0;
  for (const StageRecord& s : stages_) peak = std::max(peak, s.peak_rss_bytes);
  run["peak_rss_bytes"] = peak;
  run["stages"] = Json::array();
  for (const StageRecord& s : stages_) {
    Json one = {{"name", s.name},
                {"version", s.version},
                {"state", s.state},
                {"why", s.why},
                {"key", s.key},
                {"content_digest", s.content_digest},
                {"inputs", s.inputs},
                {"tools", s.tools},
                {"summary", s.summary},
                {"seconds", s.seconds},
                {"cpu_seconds", s.cpu_seconds},
                {"peak_rss_bytes", s.peak_rss_bytes}};
    one["metrics"] = Json::object();
    for (const auto& [name, value] : s.metrics) one["metrics"][name] = std::isfinite(value) ? Json(value) : Json(nullptr);
    one["warnings"] = s.warnings;
    run["stages"].push_back(std::move(one));
  }
  run["options"] = Json::object();
  for (const Option& o : settings.options.table.options) run["options"][o.path] = {{"value", o.text()}, {"origin", o.origin}};
  run["licence"] = "Apache-2.0; vitrine-mesh (CGAL) and vitrine-sfm (Ceres with SuiteSparse) are GPL-3.0-or-later as a whole";
  write_file(desc_.project / "run.json", run.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
  write_file(desc_.project / "config.resolved.yaml",
             "# Every value of the last run and where it came from; can be given back with -c.\n" +
                 yaml_text(settings.options.table, {.origins = true}));
}

}  // namespace vitrine
