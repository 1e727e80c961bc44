#include "core/intake/photos/measures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/scene/image/resample.h"
#include "core/foundation/math/color.h"
#include "core/foundation/math/median.h"

namespace vitrine {

namespace {

constexpr int kThumbnail = 32;
constexpr uint8_t kWhite = 253, kBlack = 2;  // JPEG keeps clipped pixels within two steps of the range ends

struct Plane {
  int width, height;
  std::vector<float> v;
  float at(int x, int y) const { return v[size_t(y) * size_t(width) + size_t(x)]; }
};

Plane grey_of(const Image8& image) {
  Plane p{image.width(), image.height(), std::vector<float>(image.pixel_count())};
  for (int y = 0; y < p.height; ++y)
    for (int x = 0; x < p.width; ++x) {
      const uint8_t* c = image.pixel(x, y);
      p.v[size_t(y) * size_t(p.width) + size_t(x)] = 0.299f * c[0] + 0.587f * c[1] + 0.114f * c[2];
    }
  return p;
}

Plane smoothed(const Plane& p, double sigma) {
  const int r = int(std::ceil(3 * sigma));
  std::vector<float> weights;
  for (int i = -r; i <= r; ++i) weights.push_back(float(std::exp(-0.5 * i * i / (sigma * sigma))));
  const float sum = std::accumulate(weights.begin(), weights.end(), 0.0f);
  for (float& w : weights) w /= sum;
  Plane rows{p.width, p.height, std::vector<float>(p.v.size(), 0.0f)}, out = rows;
  const size_t width = size_t(p.width);
  std::vector<float> padded(width + 2 * size_t(r));
  for (int y = 0; y < p.height; ++y) {
    const float* from = &p.v[size_t(y) * width];
    for (size_t x = 0; x < padded.size(); ++x) padded[x] = from[std::clamp(int(x) - r, 0, p.width - 1)];
    float* to = &rows.v[size_t(y) * width];
    for (size_t i = 0; i < weights.size(); ++i)
      for (size_t x = 0; x < width; ++x) to[x] += weights[i] * padded[x + i];
  }
  for (int y = 0; y < p.height; ++y) {
    float* to = &out.v[size_t(y) * width];
    for (int i = -r; i <= r; ++i) {
      const float* from = &rows.v[size_t(std::clamp(y + i, 0, p.height - 1)) * width];
      for (size_t x = 0; x < width; ++x) to[x] += weights[size_t(i + r)] * from[x];
    }
  }
  return out;
}

struct Slope {
  float x, y;
  float squared() const { return x * x + y * y; }
};
Slope slope_at(const Plane& p, int x, int y) {
  return {0.5f * (p.at(x + 1, y) - p.at(x - 1, y)), 0.5f * (p.at(x, y + 1) - p.at(x, y - 1))};
}

void measure_blur(const Plane& grey, PhotoMeasures& out) {
  constexpr double kFirst = 1, kSecond = 2;      // smoothings: the first suppresses noise, the second measures the edge width
  constexpr double kSlope = 1.0 / 3 + 1.0 / 12;  // variance of a central difference, two pixels wide, and of the pixel footprint
  constexpr size_t kDirections = 4, kFewestEdges = 60;
  constexpr float kNoise = 2.0f;       // of 255 per pixel: weaker slopes after the first smoothing are noise or shading
  constexpr double kStrongest = 0.25;  // of the edges of a direction: weak ones are textures, narrower than an edge
  const Plane fine = smoothed(grey, kFirst), coarse = smoothed(grey, kSecond);
  struct Edge {
    float slope2, ratio2;
  };
  std::array<std::vector<Edge>, kDirections> edges;
  for (int y = 2; y + 2 < grey.height; ++y)
    for (int x = 2; x + 2 < grey.width; ++x) {
      const Slope s = slope_at(fine, x, y);
      const float m = s.squared();
      if (m < kNoise * kNoise) continue;
      const double angle = std::atan2(s.y, s.x) + 2 * std::numbers::pi;
      const size_t direction = size_t(std::lround(angle / (std::numbers::pi / kDirections))) % kDirections;
      static constexpr int kStepX[] = {1, 1, 0, -1}, kStepY[] = {0, 1, 1, 1};
      const int dx = kStepX[direction], dy = kStepY[direction];
      if (slope_at(fine, x + dx, y + dy).squared() > m || slope_at(fine, x - dx, y - dy).squared() >= m) continue;
      const float second = slope_at(coarse, x, y).squared();
      if (second > 0) edges[direction].push_back({m, m / second});
    }
  std::optional<double> worst, best;
  for (std::vector<Edge>& of_direction : edges) {
    const size_t strongest = size_t(kStrongest * double(of_direction.size()));
    if (strongest < kFewestEdges) continue;
    std::nth_element(of_direction.begin(), of_direction.begin() + long(strongest), of_direction.end(),
                     [](const Edge& a, const Edge& b) { return a.slope2 > b.slope2; });
    std::vector<float> ratios;
    for (size_t i = 0; i < strongest; ++i) ratios.push_back(of_direction[i].ratio2);
    const double r2 = std::max(double(upper_median(std::move(ratios))), 1.0001);
    const double s2 = (kSecond * kSecond - r2 * kFirst * kFirst) / (r2 - 1) - kSlope;
    const double s = std::sqrt(std::max(s2, 0.0));
    worst = std::max(worst.value_or(s), s);
    best = std::min(best.value_or(s), s);
  }
  if (!worst) return;
  constexpr double kSharp = 0.5;  // lower bound of both blurs: below it the pixel size dominates
  out.blur_px = *worst;
  out.blur_ratio = std::max(*worst, kSharp) / std::max(*best, kSharp);
}

// Shi and Tomasi: a corner has a large smaller eigenvalue of the structure tensor.
void measure_texture(const Plane& grey, PhotoMeasures& out) {
  constexpr int kCell = 16, kWindow = 4;
  constexpr float kCorner = 36.0f * kWindow * kWindow;  // slopes of six steps of 255 in both directions
  size_t cells = 0, textured = 0;
  for (int top = 0; top + kCell <= grey.height; top += kCell)
    for (int left = 0; left + kCell <= grey.width; left += kCell) {
      ++cells;
      bool corner = false;
      for (int wy = top; wy < top + kCell && !corner; wy += kWindow)
        for (int wx = left; wx < left + kCell && !corner; wx += kWindow) {
          float xx = 0, xy = 0, yy = 0;
          for (int y = std::max(wy, 1); y < std::min(wy + kWindow, grey.height - 1); ++y)
            for (int x = std::max(wx, 1); x < std::min(wx + kWindow, grey.width - 1); ++x) {
              const Slope s = slope_at(grey, x, y);
              xx += s.x * s.x, xy += s.x * s.y, yy += s.y * s.y;
            }
          corner = 0.5f * (xx + yy - std::hypot(xx - yy, 2 * xy)) > kCorner;
        }
      textured += corner;
    }
  out.texture = cells > 0 ? double(textured) / double(cells) : 0;
}

void measure_exposure(const Image8& image, PhotoMeasures& out) {
  std::array<float, 256> linear;
  for (size_t i = 0; i < linear.size(); ++i) linear[i] = linear_from_srgb(float(i) / 255.0f);
  double luminance = 0, channels[3] = {};
  size_t high = 0, low = 0, inside = 0;
  for (int y = 0; y < image.height(); ++y)
    for (int x = 0; x < image.width(); ++x) {
      const uint8_t* c = image.pixel(x, y);
      luminance += 0.2126 * linear[c[0]] + 0.7152 * linear[c[1]] + 0.0722 * linear[c[2]];
      const auto [least, most] = std::minmax({c[0], c[1], c[2]});
      high += most >= kWhite;
      low += most <= kBlack;
      if (most >= kWhite || least <= kBlack) continue;
      ++inside;
      for (int k = 0; k < 3; ++k) channels[k] += linear[c[k]];
    }
  const double n = double(image.pixel_count());
  out.clipped_high = double(high) / n;
  out.clipped_low = double(low) / n;
  constexpr double kDarkest = 1.0 / 4096;
  out.brightness_ev = std::log2(std::max(luminance / n, kDarkest));
  if (inside == 0) return;
  out.red_green = std::log2(channels[0] / channels[1]);
  out.blue_green = std::log2(channels[2] / channels[1]);
}

std::vector<float> thumbnail_of(const Plane& grey) {
  ImageF image(grey.width, grey.height, 1);
  std::copy(grey.v.begin(), grey.v.end(), image.data().begin());
  const ImageF small = resized(image, kThumbnail, kThumbnail);
  std::vector<float> t(small.data().begin(), small.data().end());
  double mean = 0, square = 0;
  for (float v : t) mean += v;
  mean /= double(t.size());
  for (float& v : t) v -= float(mean), square += double(v) * v;
  square /= double(t.size());
  constexpr double kFlat = 1;  // a step of 255
  if (square < kFlat) return {};
  for (float& v : t) v /= float(std::sqrt(square));
  return t;
}

}  // namespace

PhotoMeasures measured(const Image8& srgb) {
  PhotoMeasures m;
  m.width = srgb.width();
  m.height = srgb.height();
  if (srgb.empty()) return m;
  const Plane grey = grey_of(srgb);
  measure_blur(grey, m);
  measure_texture(grey, m);
  measure_exposure(srgb, m);
  m.thumbnail = thumbnail_of(grey);
  return m;
}

double likeness(const PhotoMeasures& a, const PhotoMeasures& b) {
  if (a.thumbnail.empty() || b.thumbnail.empty()) return 0;
  double sum = 0;
  for (size_t i = 0; i < a.thumbnail.size(); ++i) sum += double(a.thumbnail[i]) * b.thumbnail[i];
  return sum / double(a.thumbnail.size());
}

}  // namespace vitrine
