// Output of a running stage: lines or a progress bar for people (stderr), and one JSON record per line for programs, in --events
// FILE, or on stdout with --log-format json, which the pipeline reads.
//
// Every record has "v", "type", "time", "stage"; configs/events.schema.json defines the types and their fields.
#pragma once

#include <condition_variable>
#include <filesystem>
#include <fstream>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

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

// Enforces --max-memory while a stage runs: polls the resident memory of the process and its child processes ten times a second.
// Above the limit it requests a stop (core/foundation/base/process.h, request_stop): the stage keeps its checkpoint and exits
// with code 6. Stages that can reduce their memory do so beforehand (ingest, sfm, optimize).

class MemoryWatch {
 public:
  // limit_bytes 0: no limit, no polling.
  MemoryWatch(size_t limit_bytes, std::string stage);
  ~MemoryWatch();
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;

 private:
  void watch(size_t limit_bytes, const std::string& stage);
  std::mutex mutex_;
  std::condition_variable end_;
  bool ended_ = false;
  std::thread thread_;
};

// Command-line options that reduce the memory of a stage.
std::string less_memory_hint(const std::string& stage);

}  // namespace vitrine
