// Short films of a picture that is scrolled sideways, made with ffmpeg.
#pragma once

#include "core/foundation/base/file.h"
#include "core/foundation/base/process.h"

namespace vitrine::test {

// Bytes of two films of twelve frames of 128 x 96 pixels: H.264 in MP4, MPEG-4 in Matroska. Without ffmpeg one that is none.
inline std::vector<std::string> scrolled_films(const fs::path& folder) {
  std::vector<std::string> films;
  const auto made = [&](const std::string& name, const std::vector<std::string>& codec) {
    std::vector<std::string> words{"ffmpeg", "-nostdin", "-v", "error", "-y", "-f", "lavfi", "-i"};
    words.push_back("testsrc2=size=128x96:rate=10:duration=0.1,loop=loop=11:size=1,scroll=horizontal=0.04");
    words.insert(words.end(), codec.begin(), codec.end());
    words.push_back((folder / name).string());
    if (find_program(words[0]) && run_process({.arguments = words}).ok()) films.push_back(read_file(folder / name));
  };
  made("scrolled.mp4", {"-c:v", "libx264", "-preset", "ultrafast", "-pix_fmt", "yuv420p", "-qp", "10"});
  made("scrolled.mkv", {"-c:v", "mpeg4", "-q:v", "2"});
  if (films.empty()) films.push_back("no film");
  return films;
}

}  // namespace vitrine::test
