// Output of a running stage: lines or a progress bar for people (stderr), and one JSON record per line for programs, in --events
// FILE, or on stdout with --log-format json, which the pipeline reads.
//
// Every record has "v", "type", "time", "stage"; configs/events.schema.json defines the types and their fields.
#pragma once

#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <string_view>

#include "core/foundation/base/error.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/timer.h"
#include "stages/stage.h"

namespace vitrine {

class Reporter {
 public:
  explicit Reporter(std::string stage) : stage_(std::move(stage)) {}
  ~Reporter();

  bool json_console = false;  // records on stdout instead of text
  bool show_progress = true;
  void write_events_to(const std::filesystem::path& file);  // appends

  void record(std::string_view type, nlohmann::ordered_json fields);
  void progress(const Progress& p);
  void error(const Error& e);
  void finish_progress();  // removes the progress bar

 private:
  std::string stage_;
  std::mutex mutex_;
  std::ofstream events_;
  Timer clock_;
  double last_bar_s_ = -1e9, last_line_s_ = -1e9, last_record_s_ = -1e9, first_fraction_ = -1;
  bool bar_shown_ = false;
};

std::string utc_time_text();  // 2026-11-21T12:00:00.123Z

}  // namespace vitrine
