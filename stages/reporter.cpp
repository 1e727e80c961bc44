#include "stages/reporter.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <ctime>
#include <iostream>

#include "core/foundation/base/file.h"
#include "core/foundation/base/log.h"
#include "core/foundation/base/terminal.h"

namespace vitrine {

using json = nlohmann::ordered_json;

namespace {
// Minimum period, seconds, of progress bar updates, log lines and records.
constexpr double kBarPeriod = 0.1, kLinePeriod = 10, kRecordPeriod = 0.5;

json number(double v) { return std::isfinite(v) ? json(v) : json(nullptr); }
}  // namespace

std::string utc_time_text() {
  const auto now = std::chrono::system_clock::now();
  const std::time_t seconds = std::chrono::system_clock::to_time_t(now);
  const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count() % 1000;
  std::tm utc{};
  gmtime_r(&seconds, &utc);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &utc);
  return fmt::format("{}.{:03}Z", text, ms);
}

Reporter::~Reporter() { finish_progress(); }

void Reporter::write_events_to(const std::filesystem::path& file) {
  make_folders(file.parent_path());
  events_.open(file, std::ios::app);
  if (!events_)
    throw Error(ErrorKind::Resource, "cannot write the events file",
                {.where = file.string(), .hint = "choose a folder you can write to", .code = "NOT_WRITABLE"});
}

void Reporter::record(std::string_view type, json fields) {
  json out = {{"v", kEventsVersion}, {"type", type}, {"time", utc_time_text()}, {"stage", stage_}};
  out.update(fields);
  const std::string line = out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
  std::lock_guard lock(mutex_);
  if (events_.is_open()) events_ << line << std::flush;
  if (json_console) std::cout << line << std::flush;
}

void Reporter::progress(const Progress& p) {
  const double fraction = std::clamp(p.fraction, 0.0, 1.0), now = clock_.seconds();
  std::string eta;
  bool record_due = false;
  {
    std::lock_guard lock(mutex_);
    if (first_fraction_ < 0) {
      first_fraction_ = fraction;
      clock_.restart();
      last_bar_s_ = last_line_s_ = last_record_s_ = -1e9;
    }
    eta = eta_text(now, fraction, first_fraction_);
    record_due = now - last_record_s_ >= kRecordPeriod || fraction >= 1;
    if (record_due) last_record_s_ = now;
    if (!json_console && show_progress && is_terminal(2)) {
      if (now - last_bar_s_ >= kBarPeriod) {
        last_bar_s_ = now;
        bar_shown_ = true;
        draw_status_line(fmt::format("{:<10} {} {:3.0f} %{}  {}", stage_, bar_text(fraction, 16), 100 * fraction,
                                     eta.empty() ? std::string() : "  ETA " + eta, p.text));
      }
    } else if (!json_console && show_progress && now - last_line_s_ >= kLinePeriod) {
      last_line_s_ = now;
      log_info("{:<10} {:3.0f} %{}  {}", stage_, 100 * fraction, eta.empty() ? std::string() : "  ETA " + eta, p.text);
    }
  }
  if (!record_due) return;
  json fields = {{"fraction", number(fraction)}, {"text", p.text}, {"values", json::object()}};
  if (!eta.empty() && fraction > first_fraction_) fields["eta_s"] = number(now * (1 - fraction) / (fraction - first_fraction_));
  for (const auto& [name, value] : p.values) fields["values"][name] = number(value);
  record("progress", std::move(fields));
}

void Reporter::finish_progress() {
  std::lock_guard lock(mutex_);
  if (bar_shown_) clear_status_line();
  bar_shown_ = false;
}

void Reporter::error(const Error& e) {
  finish_progress();
  const ErrorDetail& d = e.detail();
  record("error", {{"kind", name(e.kind())},
                   {"exit", exit_code(e.kind())},
                   {"code", d.code},
                   {"message", e.message()},
                   {"where", d.where},
                   {"why", d.why},
                   {"hint", d.hint}});
  if (!json_console) log_error("{}", e.with_prefix());
}

}  // namespace vitrine
