// Frames of a film as raw pixels, decoded by ffmpeg (a child process) and passed through a FIFO, each with its presentation
// time. Frames are identified by these times, never by numbers: phones write variable frame rates.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "core/intake/film/film_info.h"

namespace vitrine {

struct FrameTime {
  int64_t pts = 0;     // in the time base of the stream
  double seconds = 0;  // from the start of the film
};

struct DecodeRequest {
  const FilmInfo& film;
  std::string filters;         // of ffmpeg, after the times are read; the frames are upright and of `frame_bytes`
  std::string pixel_format;    // "gray", "rgb24", "rgb48le"
  size_t frame_bytes = 0;      // of one frame
  std::vector<int64_t> only;   // presentation times, ascending; empty = all frames
  std::filesystem::path work;  // folder for the FIFO
};

// `on_frame(n, bytes)` is called for each frame in order. Returns the times of all frames. Throws Error{Input} with the code
// BAD_FILM if no frame can be decoded; `warnings` receives the last message of ffmpeg about damage.
std::vector<FrameTime> decode_frames(const DecodeRequest& request,
                                     const std::function<void(size_t, std::span<const uint8_t>)>& on_frame,
                                     std::string& warnings);

// A line of ffmpeg's filter `showinfo`: "... n: 0 pts: 512 pts_time:0.04 ...". False if it is none.
bool parse_frame_time(std::string_view line, FrameTime& time);

}  // namespace vitrine
