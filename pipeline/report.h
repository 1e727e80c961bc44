// What a run says: one line per stage for people (stdout), records for programs (events.jsonl, or stdout with --log-format json),
// and at the end run.json and config.resolved.yaml in the output folder.
#pragma once

#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/error.h"
#include "core/base/json.h"
#include "core/base/timer.h"
#include "pipeline/plan.h"

namespace vitrine {

struct ReportDesc {
  fs::path project = {};
  bool json = false, quiet = false, show_progress = true;
  std::vector<std::string> command = {};
};

struct StageRecord {
  std::string name, state, why, key, content_digest, summary;
  int version = 1;
  double seconds = 0, cpu_seconds = 0;
  size_t peak_rss_bytes = 0;
  std::map<std::string, double> metrics;
  std::map<std::string, std::string> inputs, tools;  // content digests; versions of external programs
  std::vector<std::string> warnings;
};

class Report {
 public:
  explicit Report(ReportDesc desc) : desc_(std::move(desc)) {}
  // Opens events.jsonl and log.txt: call when the folder exists and is locked.
  void open();

  void line(std::string_view text);  // a line for people
  void note(std::string_view text);  // the same between two stages: indented, broken at words
  void record(std::string_view type, nlohmann::ordered_json fields);
  void stage_begins(size_t number, size_t count, const Step& step);
  // A line that the running stage printed: a record is shown as a bar, a line or a note; everything else goes through as it is.
  void stage_line(std::string_view text);
  void stage_ends(const Manifest& manifest, StepState how);  // Cached or Kept: not computed now; else it was
  void stage_failed(const Error& error);
  // A record of an error that no stage has told: the stage that just ended badly has printed its own.
  void untold_error(const Error& error);
  // Takes back the error record of the stage that just ended.
  const std::string& error_record() const { return error_record_; }
  // run.json and config.resolved.yaml, and the record run_end.
  void finish(const Settings& settings, int exit_code);

 private:
  void log(std::string_view text);            // log.txt alone
  void console(std::string_view text) const;  // people alone
  void progress(const nlohmann::json& event);
  std::string prefix() const;
  ReportDesc desc_;
  std::ofstream events_, log_;
  Timer clock_;
  std::string started_ = {}, error_record_;
  size_t number_ = 0, count_ = 0;
  double last_line_s_ = 0;
  std::vector<StageRecord> stages_;
};

// The record "error" of a run that ended before its output folder could be opened, as one line.
std::string early_error_record(const Error& error);

std::string utc_now();

}  // namespace vitrine
