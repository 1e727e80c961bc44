// Properties of a film file, read with ffprobe (a child process): size, rotation, duration, colours. Parsing of the film itself
// is left to ffmpeg; only its own containers are allowed, so that no playlist opens further files.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "core/scene/image/color_profile.h"

namespace vitrine {

struct FilmInfo {
  std::filesystem::path path;
  int stream = 0;                   // index of the video stream
  int width = 0, height = 0;        // as stored, with square pixels
  int orientation = 1;              // EXIF 1..8 that turns stored frames upright, from the display matrix
  double seconds = 0;               // duration; 0 = unknown
  std::string codec, pixel_format;  // names of ffmpeg
  int bits = 8;                     // per sample
  bool interlaced = false;
  Cicp color{.primaries = 1, .transfer = 1};  // of the frames as RGB
  bool full_range = false, is_rgb = false;    // samples of the file
  std::string matrix = "bt709";               // of YCbCr, a name of ffmpeg's scale filter
  std::vector<std::string> notes;             // assumptions: "its colours are not tagged: BT.709 is assumed"
};

// The arguments that open `film` for reading: protocol and containers are limited.
std::vector<std::string> film_input(const std::filesystem::path& film);
// Path of ffmpeg or ffprobe. Throws Error{Dependency} with the code NO_FFMPEG.
std::string film_program(std::string_view name);

// Throws Error{Input} with the code BAD_FILM: empty, truncated, no film, no video stream, encrypted, unsupported colours.
FilmInfo read_film_info(const std::filesystem::path& film);
// The same from the JSON text of `ffprobe -show_format -show_streams`.
FilmInfo parse_film_info(std::string_view json, const std::filesystem::path& film);

[[noreturn]] void throw_bad_film(const std::filesystem::path& film, std::string why, std::string hint);

}  // namespace vitrine
