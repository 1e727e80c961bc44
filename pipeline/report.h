// Output of a run: one line per stage for people (stdout), JSON records for programs (events.jsonl, or stdout with --log-format
// json), and finally run.json and config.resolved.yaml in the output folder.
#pragma once

#include <fstream>
#include <string>
#include <string_view>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/timer.h"
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
  // Opens events.jsonl and log.txt. The folder must exist and be locked.
  void open();

  void line(std::string_view text);  // prints a line
  void note(std::string_view text);  // prints an indented, wrapped line between two stages
  void record(std::string_view type, nlohmann::ordered_json fields);
  void stage_begins(size_t number, size_t count, const Step& step);
  // Handles an output line of the running stage: records are shown as a progress bar, line or note; other lines pass unchanged.
  void stage_line(std::string_view text);
  void stage_ends(const Manifest& manifest, StepState how);  // `how`: Cached or Kept if it was not computed in this run
  void stage_failed(const Error& error);
  // Records an error that no stage has reported.
  void untold_error(const Error& error);
  // The error record of the last stage.
  const std::string& error_record() const { return error_record_; }
  // Writes run.json, config.resolved.yaml and the record run_end.
  void finish(const Settings& settings, int exit_code);

 private:
  void log(std::string_view text);            // to log.txt only
  void console(std::string_view text) const;  // to the console only
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

// The "error" record, as one line, of a run that failed before its output folder was opened.
std::string early_error_record(const Error& error);

std::string utc_now();

}  // namespace vitrine
