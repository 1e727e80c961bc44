#include "core/foundation/base/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

namespace vitrine {

namespace {
bool environment_has(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr && *value != 0;
}
}  // namespace

bool is_terminal(int fd) {
  const char* term = std::getenv("TERM");
  const bool dumb = term == nullptr || std::string_view(term) == "dumb";
  return isatty(fd) == 1 && !dumb && !environment_has("CI");
}

bool colour_wanted(int fd) { return is_terminal(fd) && !environment_has("NO_COLOR"); }

size_t terminal_columns(int fd) {
  winsize size{};
  if (ioctl(fd, TIOCGWINSZ, &size) == 0 && size.ws_col >= 20) return size.ws_col;
  return 80;
}

std::string duration_text(double seconds) {
  if (!(seconds >= 0)) return "?";
  if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
  if (seconds < 119.5) return fmt::format("{:.0f} s", seconds);
  const long minutes = std::lround(seconds / 60);
  if (minutes < 60) return fmt::format("{} min", minutes);
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

std::string bytes_text(size_t bytes) {
  constexpr const char* kUnits[] = {"B", "KiB", "MiB", "GiB", "TiB"};
  double value = static_cast<double>(bytes);
  size_t unit = 0;
  while (value >= 1000 && unit + 1 < std::size(kUnits)) {
    value /= 1024;
    ++unit;
  }
  return unit == 0 || value >= 99.95 ? fmt::format("{:.0f} {}", value, kUnits[unit])
                                     : fmt::format("{:.1f} {}", value, kUnits[unit]);
}

std::string eta_text(double elapsed_s, double fraction_done, double fraction_at_start) {
  // Below these the estimate is mostly noise.
  constexpr double kLeastFraction = 0.01, kLeastSeconds = 1.5;
  const double done = fraction_done - fraction_at_start;
  if (done < kLeastFraction || elapsed_s < kLeastSeconds) return {};
  return duration_text(elapsed_s * std::max(0.0, 1 - fraction_done) / done);
}

std::string bar_text(double fraction, size_t width) {
  const size_t full = static_cast<size_t>(std::lround(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(width)));
  return std::string(full, '#') + std::string(width - full, '-');
}

std::string cut_to_columns(std::string_view text, size_t columns) {
  size_t seen = 0;
  for (size_t i = 0; i < text.size(); ++i) {
    const bool continuation = (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80;
    if (!continuation && ++seen > columns) return std::string(text.substr(0, i));
  }
  return std::string(text);
}

void draw_status_line(std::string_view text) {
  if (!is_terminal(2)) return;
  const std::string line = cut_to_columns(text, terminal_columns(2) - 1);
  // The cursor returns to the line start, so that the next output overwrites this line.
  fmt::print(stderr, "\r{}{}\r", line, kEraseLine);
  std::fflush(stderr);
}

void clear_status_line() { draw_status_line({}); }

}  // namespace vitrine
