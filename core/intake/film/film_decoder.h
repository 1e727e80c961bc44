// Frames of a film as raw pixels, decoded by ffmpeg (a child process) and passed through a FIFO, each with its presentation
// time. Frames are identified by these times, never by numbers: phones write variable frame rates.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/intake/film/film_info.h"

namespace vitrine {

// Unit of times: `over` / `under` seconds.
struct TimeBase {
  int64_t over = 1, under = 1;
  double seconds(int64_t pts) const { return double(pts) * double(over) / double(under); }
};

struct FrameTime {
  int64_t pts = 0;     // in the time base of the decoded frames; different for each frame
  double seconds = 0;  // from the start of the film
};

struct DecodeRequest {
  const FilmInfo& film;
  std::string filters;        // of ffmpeg, after the times are read; the frames are upright and of `frame_bytes`
  std::string pixel_format;   // "gray", "rgb24", "rgb48le"
  size_t frame_bytes = 0;     // of one frame
  std::vector<int64_t> only;  // presentation times, ascending; empty = all frames
};

// `on_frame(n, bytes)` is called for each frame in order of time; frames without a time, or not later than the one before, are
// left out. Returns the times of all frames. Throws Error{Input} with the code
// BAD_FILM if no frame can be decoded; `warnings` receives the last message of ffmpeg about damage.
std::vector<FrameTime> decode_frames(const DecodeRequest& request,
                                     const std::function<void(size_t, std::span<const uint8_t>)>& on_frame,
                                     std::string& warnings);

// Time of a line "... n: 0 pts: 512 pts_time:0.04 ..." of ffmpeg's filter `showinfo`. Nullopt if it is none.
std::optional<int64_t> parse_frame_time(std::string_view line);
// Its line "... config in time_base: 1/12800, frame_rate: 25/1". False if it is none, or no positive fraction.
bool parse_time_base(std::string_view line, TimeBase& base);

}  // namespace vitrine
