// Logging for library code. stage_main or the pipeline selects the outputs (console, log.txt). Based on spdlog.
#pragma once

#include <filesystem>
#include <string_view>

#include <fmt/format.h>

namespace vitrine {

enum class LogLevel { Debug, Info, Warning, Error, Quiet };

// Console output goes to stderr; stdout is for data. Colour only on a terminal without NO_COLOR.
void set_log_console(LogLevel level, bool colour);
void set_log_file(const std::filesystem::path& path);      // appends; level Debug and above
void log_line(LogLevel level, std::string_view text);

template <class... Args> void log_debug(fmt::format_string<Args...> f, Args&&... a) {
  log_line(LogLevel::Debug, fmt::format(f, std::forward<Args>(a)...));
}
template <class... Args> void log_info(fmt::format_string<Args...> f, Args&&... a) {
  log_line(LogLevel::Info, fmt::format(f, std::forward<Args>(a)...));
}
template <class... Args> void log_warning(fmt::format_string<Args...> f, Args&&... a) {
  log_line(LogLevel::Warning, fmt::format(f, std::forward<Args>(a)...));
}
template <class... Args> void log_error(fmt::format_string<Args...> f, Args&&... a) {
  log_line(LogLevel::Error, fmt::format(f, std::forward<Args>(a)...));
}

}  // namespace vitrine
