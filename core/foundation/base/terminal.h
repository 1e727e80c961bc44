// Terminal output helpers shared by stages and pipeline: terminal detection, width, colours; formatting of durations and sizes;
// a status line redrawn in place.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

inline constexpr std::string_view kEraseLine = "\033[K";

bool is_terminal(int fd);         // supports redrawing a line: not dumb, and not in CI
bool colour_wanted(int fd);       // a terminal, and NO_COLOR is not set
size_t terminal_columns(int fd);  // 80 when unknown

std::string duration_text(double seconds);  // "0.4 s", "12 s", "6 min", "1 h 24 min"
std::string bytes_text(size_t bytes);       // "512 B", "9.1 GiB"
// Remaining time from two progress samples of the same work; empty if there is too little data.
std::string eta_text(double elapsed_s, double fraction_done, double fraction_at_start);
// "########----" of `width` characters.
std::string bar_text(double fraction, size_t width);
// Truncates to `columns` columns (UTF-8 aware, one column per character).
std::string cut_to_columns(std::string_view text, size_t columns);

// Redraws the status line on stderr. No output if stderr is not a terminal.
void draw_status_line(std::string_view text);
void clear_status_line();

}  // namespace vitrine
