#include "core/intake/film/film_decoder.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <charconv>
#include <cmath>
#include <cstring>
#include <exception>
#include <optional>
#include <thread>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"

namespace vitrine {

namespace {

constexpr size_t kMostFrames = 2'000'000;  // nine hours at 60 Hz

// Filters that turn a stored frame upright, by EXIF orientation.
constexpr const char* kTurns[] = {
    "", "hflip,", "hflip,vflip,", "vflip,", "transpose=0,", "transpose=1,", "transpose=3,", "transpose=2,"};

// Reading end of a FIFO that another process opens by its path.
class Fifo {
 public:
  explicit Fifo(const fs::path& path) {
    if (mkfifo(path.c_str(), 0600) != 0) throw_write_error(path, errno);
    fd_ = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0) throw_write_error(path, errno);
  }
  ~Fifo() { close(fd_); }
  Fifo(const Fifo&) = delete;
  Fifo& operator=(const Fifo&) = delete;

  // Reads into [data, data + size) until it is full or the writer has ended; returns the bytes read.
  size_t read_all(uint8_t* data, size_t size, const std::atomic<bool>& ended) const {
    size_t have = 0;
    while (have < size) {
      const bool last = ended.load();  // before reading: what the writer left is in the pipe by now
      const ssize_t n = read(fd_, data + have, size - have);
      if (n > 0) {
        have += static_cast<size_t>(n);
        continue;
      }
      if (last && (n == 0 || errno != EINTR)) break;
      constexpr int kWaitMs = 50;
      pollfd p{fd_, POLLIN, 0};
      poll(&p, 1, kWaitMs);
      if ((p.revents & POLLHUP) != 0 && (p.revents & POLLIN) == 0) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return have;
  }

 private:
  int fd_ = -1;
};

// Expression of ffmpeg that is 1 for these times. A binary search: ffmpeg 5.1 refuses sums of more than a hundred terms.
std::string is_one_of(std::span<const int64_t> times) {
  if (times.size() == 1) return fmt::format("eq(pts,{})", times[0]);
  const size_t half = times.size() / 2;
  return fmt::format("if(lt(pts,{}),{},{})", times[half], is_one_of(times.first(half)), is_one_of(times.subspan(half)));
}

std::vector<std::string> command_of(const DecodeRequest& r, const fs::path& fifo) {
  std::string filters = r.film.interlaced ? "yadif=deint=all," : "";  // first: it needs the neighbours of a frame
  // Damaged films, and films with times that were rounded, have frames without a time or with that of an earlier one. Without
  // them a time names one frame, in any pass.
  filters += "select='not(isnan(pts)+lte(pts,prev_selected_pts))";
  if (!r.only.empty()) filters += "*" + is_one_of(r.only);
  filters += "',";
  filters += "showinfo=checksum=0,";
  // Frames leave far apart: close times of a variable rate would become equal in the time base of the output and be dropped.
  filters += r.filters + "," + kTurns[r.film.orientation - 1] + "format=" + r.pixel_format + ",setpts=100*N/TB";
  std::vector<std::string> words{
      film_program("ffmpeg"), "-nostdin",      "-hide_banner", "-nostats", "-loglevel",
      "level+info",           "-noautorotate", "-y",           "-threads", std::to_string(thread_limit())};
  for (const std::string& w : film_input(r.film.path)) words.push_back(w);
  words.insert(words.end(), {"-map", fmt::format("0:{}", r.film.stream), "-fps_mode", "passthrough", "-vf", filters});
  if (!r.only.empty()) words.insert(words.end(), {"-frames:v", std::to_string(r.only.size())});
  words.insert(words.end(), {"-f", "rawvideo", "file:" + fifo.string()});
  return words;
}

// ffmpeg in a thread of its own, while this one reads the frames.
struct Child {
  std::thread thread;
  std::atomic<bool> ended{false};
  std::exception_ptr failure;
  ProcessResult result;
  std::vector<FrameTime> times;
  TimeBase base;
  std::string complaint;

  void start(std::vector<std::string> words) {
    thread = std::thread([this, words = std::move(words)] {
      try {
        result = run_process({.arguments = words, .on_line = [this](std::string_view line) { take(line); }});
      } catch (...) {
        failure = std::current_exception();
      }
      ended = true;
    });
  }
  void take(std::string_view line) {
    if (parse_time_base(line, base)) return;
    if (const auto pts = parse_frame_time(line)) {
      if (times.size() < kMostFrames) times.push_back({*pts, base.seconds(*pts)});
      return;
    }
    for (const std::string_view level : {"[error] ", "[fatal] "})
      if (const size_t at = line.find(level); at != line.npos) complaint = line.substr(at + level.size());
  }
  ~Child() {
    if (thread.joinable()) thread.join();
  }
};

}  // namespace

namespace {

// The integer after `key` in a line of showinfo; `rest` is what follows it.
std::optional<int64_t> number_after(std::string_view line, std::string_view key, std::string_view& rest) {
  const size_t at = line.find("showinfo") == line.npos ? line.npos : line.find(key);
  if (at == line.npos) return std::nullopt;
  rest = line.substr(at + key.size());
  while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
  int64_t value = 0;
  const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  if (error != std::errc()) return std::nullopt;
  rest.remove_prefix(size_t(end - rest.data()));
  return value;
}

}  // namespace

std::optional<int64_t> parse_frame_time(std::string_view line) {
  std::string_view rest;
  const auto pts = number_after(line, " pts:", rest);
  return pts && rest.starts_with(' ') ? pts : std::nullopt;
}

bool parse_time_base(std::string_view line, TimeBase& base) {
  std::string_view rest;
  const auto over = number_after(line, " config in time_base:", rest);
  if (!over || *over <= 0 || !rest.starts_with('/')) return false;
  rest.remove_prefix(1);
  int64_t under = 0;
  if (std::from_chars(rest.data(), rest.data() + rest.size(), under).ec != std::errc() || under <= 0) return false;
  base = {*over, under};
  return true;
}

std::vector<FrameTime> decode_frames(const DecodeRequest& request,
                                     const std::function<void(size_t, std::span<const uint8_t>)>& on_frame,
                                     std::string& warnings) {
  const TemporaryFolder folder("vitrine-film");  // not that of the output: some network drives have no FIFOs
  const fs::path path = folder.path() / "frames.fifo";
  const std::vector<std::string> words = command_of(request, path);
  size_t count = 0;
  Child child;
  {
    const Fifo fifo(path);
    child.start(words);
    std::vector<uint8_t> frame(request.frame_bytes);
    while (count < kMostFrames && fifo.read_all(frame.data(), frame.size(), child.ended) == frame.size()) {
      throw_if_interrupted();
      on_frame(count++, frame);
    }
  }  // the FIFO is closed: ffmpeg, which has opened it, ends if it still writes
  child.thread.join();
  if (child.failure != nullptr) std::rethrow_exception(child.failure);
  throw_if_interrupted();
  count = std::min(count, child.times.size());
  if (count == 0)
    throw_bad_film(request.film.path,
                   fmt::format("none of its frames can be decoded ({}): damaged, encrypted, or without pictures",
                               child.complaint.empty() ? "no frame" : child.complaint),
                   "copy it from the camera again, or export it as H.264 in MP4 without copy protection");
  if (!child.complaint.empty()) warnings = child.complaint;
  child.times.resize(count);
  return std::move(child.times);
}

}  // namespace vitrine
