#include "core/intake/film/film_track.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include <fmt/format.h>

#include "core/foundation/math/median.h"

namespace vitrine {

namespace {

constexpr int kGreySide = 640, kReduction = 4, kBlock = 16;
constexpr int kSearch = 12;        // pixels of the reduced frames: 7.5 % of the longest side
constexpr double kAnchorStep = 3;  // pixels of the reduced frames
constexpr double kTexture = 5;     // standard deviation of a block, of 255
constexpr size_t kFewestBlocks = 4;

// Sums of squared central differences along one direction, as stored and after smoothing with 1 4 6 4 1 along it.
struct Energy {
  int64_t sharp = 0, smooth = 0;
  double lost() const { return smooth > 0 ? std::max(double(sharp) / double(smooth) - 1, 0.0) : 0; }
};

// `step`: distance of neighbours along the direction; `count` pixels in each of `lines` lines that are `pitch` apart.
Energy energy_along(const uint8_t* data, size_t lines, size_t pitch, size_t count, size_t step) {
  Energy e;
  constexpr int kSum = 16;   // of the smoothing weights
  constexpr int kNoise = 3;  // of 255: weaker smoothed slopes are noise
  if (count < 7) return e;
  for (size_t line = 0; line < lines; ++line) {
    const uint8_t* p = data + line * pitch;
    const auto at = [&](size_t i) { return int(p[i * step]); };
    for (size_t i = 3; i + 3 < count; ++i) {
      const int slope = at(i + 1) - at(i - 1);
      const int wide = at(i + 3) + 4 * at(i + 2) + 5 * at(i + 1) - 5 * at(i - 1) - 4 * at(i - 2) - at(i - 3);
      if (std::abs(wide) < kNoise * kSum) continue;
      e.sharp += int64_t(slope) * slope * kSum * kSum;
      e.smooth += int64_t(wide) * wide;
    }
  }
  return e;
}

struct Block {
  int x, y;
};

double deviation(const uint8_t* p, size_t pitch) {
  int64_t sum = 0, square = 0;
  for (int y = 0; y < kBlock; ++y)
    for (int x = 0; x < kBlock; ++x) {
      const int v = p[size_t(y) * pitch + size_t(x)];
      sum += v;
      square += int64_t(v) * v;
    }
  const double n = kBlock * kBlock, mean = double(sum) / n;
  return std::sqrt(std::max(double(square) / n - mean * mean, 0.0));
}

int difference(const uint8_t* a, const uint8_t* b, size_t pitch, int offset) {
  int sum = 0;
  for (int y = 0; y < kBlock; ++y)
    for (int x = 0; x < kBlock; ++x)
      sum += std::abs(int(b[size_t(y) * pitch + size_t(x)]) - int(a[size_t(y) * pitch + size_t(x)]) - offset);
  return sum;
}

}  // namespace

GreySize grey_size(int width, int height) {
  const int longest = std::max(width, height);
  if (longest <= kGreySide) return {width, height};
  const double s = double(kGreySide) / longest;
  return {std::max(int(std::lround(width * s)), 1), std::max(int(std::lround(height * s)), 1)};
}

double sharpness_of(std::span<const uint8_t> grey, GreySize size) {
  const size_t w = size_t(size.width), h = size_t(size.height);
  const Energy across = energy_along(grey.data(), h, w, w, 1), down = energy_along(grey.data(), w, 1, h, w);
  if (across.smooth == 0 || down.smooth == 0) return std::max(across.lost(), down.lost());
  return std::min(across.lost(), down.lost());  // motion blurs one direction
}

FilmTracker::FilmTracker(GreySize size) : size_(size) {}

FilmTracker::Small FilmTracker::reduced(std::span<const uint8_t> grey) const {
  const int factor = std::max(size_.width, size_.height) > kGreySide / 2 ? kReduction : 1;
  Small out{size_.width / factor, size_.height / factor, {}, 0};
  out.v.resize(size_t(out.width) * size_t(out.height));
  int64_t total = 0;
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x) {
      int sum = 0;
      for (int v = 0; v < factor; ++v)
        for (int u = 0; u < factor; ++u) sum += grey[size_t(y * factor + v) * size_t(size_.width) + size_t(x * factor + u)];
      const uint8_t mean = uint8_t((sum + factor * factor / 2) / (factor * factor));
      out.v[size_t(y) * size_t(out.width) + size_t(x)] = mean;
      total += mean;
    }
  out.mean = out.v.empty() ? 0 : double(total) / double(out.v.size());
  return out;
}

double FilmTracker::displacement(const Small& from, const Small& to) const {
  const size_t pitch = size_t(from.width);
  const int offset = int(std::lround(to.mean - from.mean));  // of another exposure
  std::vector<float> lengths;
  size_t textured = 0;
  for (int by = 0; by + kBlock <= from.height; by += kBlock)
    for (int bx = 0; bx + kBlock <= from.width; bx += kBlock) {
      const uint8_t* block = &from.v[size_t(by) * pitch + size_t(bx)];
      const double contrast = deviation(block, pitch);
      if (contrast < kTexture) continue;
      ++textured;
      int best = -1, best_x = 0, best_y = 0;
      for (int dy = -kSearch; dy <= kSearch; ++dy)
        for (int dx = -kSearch; dx <= kSearch; ++dx) {
          const int x = bx + dx, y = by + dy;
          if (x < 0 || y < 0 || x + kBlock > to.width || y + kBlock > to.height) continue;
          constexpr int kPerPixel = 24;  // prefers small displacements along edges
          const int cost =
              difference(block, &to.v[size_t(y) * pitch + size_t(x)], pitch, offset) + kPerPixel * (std::abs(dx) + std::abs(dy));
          if (best < 0 || cost < best) best = cost, best_x = dx, best_y = dy;
        }
      constexpr double kMatched = 0.7;  // of the contrast, mean absolute difference
      if (best < kMatched * contrast * kBlock * kBlock) lengths.push_back(float(std::hypot(best_x, best_y)));
    }
  if (textured < kFewestBlocks) return 0;  // nothing to follow
  constexpr size_t kLostShare = 4;
  if (kLostShare * lengths.size() < textured) return kSearch;  // another scene, or too fast
  return upper_median(std::move(lengths));
}

TrackedFrame FilmTracker::next(std::span<const uint8_t> grey) {
  Small now = reduced(grey);
  if (!anchor_.v.empty()) {
    const double away = displacement(anchor_, now);
    farthest_ = std::max(farthest_, travelled_ + away);
    if (away >= kAnchorStep) {
      travelled_ += away;
      anchor_ = std::move(now);
    }
  } else {
    anchor_ = std::move(now);
  }
  const double side = std::max(anchor_.width, anchor_.height);
  return {{}, sharpness_of(grey, size_), side > 0 ? farthest_ / side : 0};
}

std::vector<TrackedFrame> track_film(const FilmInfo& film, const std::function<void(double)>& progress, std::string& warnings) {
  const GreySize stored = grey_size(film.width, film.height);
  const GreySize size = film.orientation >= 5 ? GreySize{stored.height, stored.width} : stored;
  FilmTracker tracker(size);
  std::vector<TrackedFrame> frames;
  const std::vector<FrameTime> times = decode_frames(
      {.film = film,
       .filters = fmt::format("scale={}:{}:flags=area+accurate_rnd+bitexact", stored.width, stored.height),
       .pixel_format = "gray",
       .frame_bytes = size_t(size.width) * size_t(size.height),
       .only = {}},
      [&](size_t n, std::span<const uint8_t> grey) {
        frames.push_back(tracker.next(grey));
        constexpr double kUsualRate = 30;
        progress(film.seconds > 0 ? std::min(double(n) / (kUsualRate * film.seconds), 1.0) : 0.5);
      },
      warnings);
  frames.resize(times.size());
  for (size_t i = 0; i < times.size(); ++i) frames[i].time = times[i];
  return frames;
}

}  // namespace vitrine
