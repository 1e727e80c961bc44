#include "core/foundation/base/log.h"

#include "core/foundation/base/terminal.h"

#include <memory>
#include <mutex>

#include <spdlog/sinks/basic_file_sink.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

namespace vitrine {

namespace {

spdlog::level::level_enum to_spdlog(LogLevel level) {
  switch (level) {
    case LogLevel::Debug: return spdlog::level::debug;
    case LogLevel::Info: return spdlog::level::info;
    case LogLevel::Warning: return spdlog::level::warn;
    case LogLevel::Error: return spdlog::level::err;
    case LogLevel::Quiet: return spdlog::level::off;
  }
  return spdlog::level::info;
}

struct Sinks {
  std::mutex mutex;
  std::shared_ptr<spdlog::sinks::sink> console, file;
  std::shared_ptr<spdlog::logger> logger;

  Sinks() { console = make_console(false); rebuild(); }
  static std::shared_ptr<spdlog::sinks::sink> make_console(bool colour) {
    // On a terminal a line first erases the progress bar (core/foundation/base/terminal.h).
    const std::string erase = is_terminal(2) ? std::string(kEraseLine) : std::string();
    if (colour) {
      auto sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
      sink->set_color_mode(spdlog::color_mode::always);
      sink->set_pattern(erase + "%^%v%$");
      return sink;
    }
    auto sink = std::make_shared<spdlog::sinks::stderr_sink_mt>();
    sink->set_pattern(erase + "%v");
    return sink;
  }
  void rebuild() {
    std::vector<spdlog::sink_ptr> all{console};
    if (file) all.push_back(file);
    logger = std::make_shared<spdlog::logger>("vitrine", all.begin(), all.end());
    logger->set_level(spdlog::level::debug);
    logger->flush_on(spdlog::level::info);
  }
};

Sinks& sinks() {
  static Sinks instance;
  return instance;
}

}  // namespace

void set_log_console(LogLevel level, bool colour) {
  std::lock_guard lock(sinks().mutex);
  sinks().console = Sinks::make_console(colour);
  sinks().console->set_level(to_spdlog(level));
  sinks().rebuild();
}

void set_log_file(const std::filesystem::path& path) {
  std::lock_guard lock(sinks().mutex);
  sinks().file = std::make_shared<spdlog::sinks::basic_file_sink_mt>(path.string());
  sinks().file->set_pattern("%Y-%m-%d %H:%M:%S.%e %-7l %v");
  sinks().file->set_level(spdlog::level::debug);
  sinks().rebuild();
}

void log_line(LogLevel level, std::string_view text) {
  std::shared_ptr<spdlog::logger> logger;
  {
    std::lock_guard lock(sinks().mutex);
    logger = sinks().logger;
  }
  logger->log(to_spdlog(level), "{}", text);
}

}  // namespace vitrine
