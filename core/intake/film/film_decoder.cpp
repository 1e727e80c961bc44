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
#include <mutex>
#include <thread>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
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
  explicit Fifo(const fs::path& path) : path_(path) {
    if (mkfifo(path.c_str(), 0600) != 0) throw_write_error(path, errno);
    fd_ = open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    if (fd_ < 0) throw_write_error(path, errno);
  }
  ~Fifo() {
    close(fd_);
    std::error_code ec;
    fs::remove(path_, ec);
  }
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
  fs::path path_;
  int fd_ = -1;
};

std::vector<std::string> command_of(const DecodeRequest& r, const fs::path& fifo) {
  std::string filters;
  if (!r.only.empty()) {
    filters = "select='";
    for (size_t i = 0; i < r.only.size(); ++i) filters += fmt::format("{}eq(pts,{})", i > 0 ? "+" : "", r.only[i]);
    filters += "',";
  }
  filters += "showinfo=checksum=0,";
  if (r.film.interlaced) filters += "yadif=deint=all,";
  // Frames leave far apart: close times of a variable rate would become equal in the time base of the output and be dropped.
  filters += r.filters + "," + kTurns[r.film.orientation - 1] + "format=" + r.pixel_format + ",setpts=100*N/TB";
  std::vector<std::string> words{film_program("ffmpeg"), "-nostdin", "-hide_banner", "-nostats", "-loglevel", "level+info",
                                 "-noautorotate",        "-y"};
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
    FrameTime time;
    if (times.size() < kMostFrames && parse_frame_time(line, time)) {
      times.push_back(time);
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

bool parse_frame_time(std::string_view line, FrameTime& time) {
  if (line.find("showinfo") == line.npos) return false;
  const auto field = [&](std::string_view key, auto& value) {
    const size_t at = line.find(key);
    if (at == line.npos) return false;
    std::string_view rest = line.substr(at + key.size());
    while (!rest.empty() && rest.front() == ' ') rest.remove_prefix(1);
    return std::from_chars(rest.data(), rest.data() + rest.size(), value).ec == std::errc();
  };
  return field(" pts:", time.pts) && field(" pts_time:", time.seconds) && std::isfinite(time.seconds);
}

std::vector<FrameTime> decode_frames(const DecodeRequest& request,
                                     const std::function<void(size_t, std::span<const uint8_t>)>& on_frame,
                                     std::string& warnings) {
  make_folders(request.work);
  const fs::path path = request.work / "frames.fifo";
  std::error_code ec;
  fs::remove(path, ec);  // of a run that was killed
  const std::vector<std::string> words = command_of(request, path);
  size_t count = 0;
  Child child;
  {
    const Fifo fifo(path);
    child.start(words);
    std::vector<uint8_t> frame(request.frame_bytes);
    std::exception_ptr failure;
    while (fifo.read_all(frame.data(), frame.size(), child.ended) == frame.size() && count < kMostFrames) {
      if (failure != nullptr) continue;  // reads to the end, so that ffmpeg ends
      try {
        throw_if_interrupted();
        on_frame(count++, frame);
      } catch (...) {
        failure = std::current_exception();
      }
    }
    child.thread.join();
    if (failure != nullptr) std::rethrow_exception(failure);
  }
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
