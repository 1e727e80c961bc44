// What a person looks at: is it a terminal, how wide, colours or not; durations and sizes in words; and one status line that is
// redrawn in place. Shared by the stages and the pipeline so that both look the same.
#pragma once

#include <string>
#include <string_view>

namespace vitrine {

inline constexpr std::string_view kEraseLine = "\033[K";

bool is_terminal(int fd);         // a terminal that can redraw a line: not dumb, and not inside CI
bool colour_wanted(int fd);       // a terminal, and NO_COLOR is not set
size_t terminal_columns(int fd);  // 80 when unknown

std::string duration_text(double seconds);  // "0.4 s", "12 s", "6 min", "1 h 24 min"
std::string bytes_text(size_t bytes);       // "512 B", "9.1 GiB"
// Time left from two moments of the same work; empty while there is too little to judge by.
std::string eta_text(double elapsed_s, double fraction_done, double fraction_at_start);
// "########----" of `width` characters.
std::string bar_text(double fraction, size_t width);
// Cut to `columns` columns (UTF-8 aware, one column per character).
std::string cut_to_columns(std::string_view text, size_t columns);

// The line that is redrawn on stderr. Silent when stderr is no terminal.
void draw_status_line(std::string_view text);
void clear_status_line();

}  // namespace vitrine
