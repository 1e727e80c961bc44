// Films: what ffprobe and ffmpeg print about them, and damaged films through ffmpeg itself.
#include <sys/wait.h>

#include "core/foundation/base/process.h"
#include "core/intake/film/photos_and_films.h"
#include "tests/fuzz/entry.h"
#include "tests/support/scrolled_film.h"

namespace vitrine {

// Two parts: the answer of ffprobe, and lines of the filter showinfo.
void fuzz_film_text(std::span<const uint8_t> bytes) {
  const auto parts = parts_of(bytes, 2);
  refuses_or_reads([&] {
    const FilmInfo info = parse_film_info(parts[0], "film.mp4");
    if (info.width < 1 || info.height < 1 || info.orientation < 1 || info.orientation > 8 || cicp_profile(info.color) == nullptr)
      throw std::logic_error("a film is read without size, direction or colours");
  });
  TimeBase base;
  std::string_view rest = parts[1];
  while (!rest.empty()) {
    const std::string_view line = rest.substr(0, rest.find('\n'));
    rest.remove_prefix(std::min(line.size() + 1, rest.size()));
    parse_time_base(line, base);
    if (const auto pts = parse_frame_time(line); pts && !std::isfinite(base.seconds(*pts)))
      throw std::logic_error("a time that is no number");
  }
}

std::vector<std::string> film_text_corpus() {
  const std::string lines =
      "[Parsed_showinfo_1 @ 0x55] [info] config in time_base: 1/12800, frame_rate: 25/1\n"
      "[Parsed_showinfo_1 @ 0x55] [info] n:   0 pts:      0 pts_time:0       pos:     48 fmt:yuv420p sar:1/1 s:128x96 i:P\n"
      "[Parsed_showinfo_1 @ 0x55] [info] n:   1 pts:    512 pts_time:0.04    pos:   4711 fmt:yuv420p sar:1/1 s:128x96 i:P\n";
  const auto film = [&](const std::string& stream) { return R"({"streams":[)" + stream + "]}" + std::string(kPartMark) + lines; };
  return {film(R"({"index":0,"codec_type":"audio","codec_name":"aac"},{"index":1,"codec_type":"video","codec_name":"hevc",)"
               R"("codec_tag_string":"hvc1","pix_fmt":"yuv420p10le","width":1920,"height":1080,"sample_aspect_ratio":"4:3",)"
               R"("color_primaries":"bt2020","color_transfer":"arib-std-b67","color_space":"bt2020nc","color_range":"tv",)"
               R"("field_order":"progressive","duration":"3.5","disposition":{"attached_pic":0},"side_data_list":[)"
               R"({"displaymatrix":"\n00000000: 0 65536 0\n00000001: -65536 0 0\n00000002: 0 0 1073741824\n"},)"
               R"({"dv_profile":8}]})"),
          film(R"({"index":0,"codec_type":"video","codec_name":"mpeg4","pix_fmt":"yuv420p","width":128,"height":96,)"
               R"("field_order":"tt","duration":"1.2"})")};
}

void fuzz_film(std::span<const uint8_t> bytes) {
  const fs::path path = input_file("film.mp4", text_of(bytes));
  refuses_or_reads([&] {
    const PhotosAndFilms all =
        photos_and_films(path, {.most_frames = 3, .work = fuzz_folder() / "film", .progress = [](double, const std::string&) {}});
    for (const FilmFrameReport& frame : all.frames)
      if (!std::isfinite(frame.time.seconds)) throw std::logic_error("a frame without a time");
  });
  if (waitpid(-1, nullptr, WNOHANG) != -1) throw std::logic_error("a child process is left");
}

std::vector<std::string> film_corpus() { return test::scrolled_films(fuzz_folder()); }

}  // namespace vitrine
