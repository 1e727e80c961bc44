#include "core/scene/image/resample.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/parallel.h"

namespace vitrine {

namespace {

struct Tap {
  int first = 0;
  std::vector<float> weights;  // normalised weights of source pixels first, first+1, ...
};

// Filter taps per target pixel: area overlap for shrinking, a tent one source pixel wide for enlarging.
std::vector<Tap> taps(int source, int target) {
  std::vector<Tap> out(static_cast<size_t>(target));
  const double step = double(source) / target;
  for (int i = 0; i < target; ++i) {
    Tap& tap = out[size_t(i)];
    if (step >= 1.0) {
      const double begin = i * step, end = (i + 1) * step;
      tap.first = std::min(int(begin), source - 1);
      for (int s = tap.first; s < source && s < end - 1e-9; ++s)
        tap.weights.push_back(float((std::min<double>(s + 1, end) - std::max<double>(s, begin)) / step));
    } else {
      const double centre = std::clamp((i + 0.5) * step - 0.5, 0.0, double(source - 1));
      tap.first = std::min(int(centre), source - 1);
      const float f = float(centre - tap.first);
      tap.weights = {1.f - f};
      if (tap.first + 1 < source && f > 0) tap.weights.push_back(f);
    }
  }
  return out;
}

}  // namespace

ImageF resized(const ImageF& image, int width, int height) {
  VITRINE_CHECK(width > 0 && height > 0 && !image.empty(), "resize {}x{} to {}x{}", image.width(), image.height(), width, height);
  if (width == image.width() && height == image.height()) return image;
  const int channels = image.channels();
  const std::vector<Tap> across = taps(image.width(), width), down = taps(image.height(), height);
  ImageF narrow(width, image.height(), channels), out(width, height, channels);
  parallel_for(size_t(image.height()), 16, [&](size_t row) {
    const int y = int(row);
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < channels; ++c) {
        const Tap& tap = across[size_t(x)];
        float sum = 0;
        for (size_t k = 0; k < tap.weights.size(); ++k) sum += tap.weights[k] * image.at(tap.first + int(k), y, c);
        narrow.at(x, y, c) = sum;
      }
  });
  parallel_for(size_t(height), 16, [&](size_t row) {
    const Tap& tap = down[row];
    float* target = out.pixel(0, int(row));
    for (size_t k = 0; k < tap.weights.size(); ++k) {
      const float* source = narrow.pixel(0, tap.first + int(k));
      for (int i = 0; i < width * channels; ++i) target[i] += tap.weights[k] * source[i];
    }
  });
  return out;
}

void sample_bilinear(const ImageF& image, double x, double y, float* out) {
  const double fx = std::clamp(x - 0.5, 0.0, double(image.width() - 1)),
               fy = std::clamp(y - 0.5, 0.0, double(image.height() - 1));
  const int x0 = int(fx), y0 = int(fy);
  const int x1 = std::min(x0 + 1, image.width() - 1), y1 = std::min(y0 + 1, image.height() - 1);
  const float u = float(fx - x0), v = float(fy - y0);
  for (int c = 0; c < image.channels(); ++c)
    out[c] = (1 - v) * ((1 - u) * image.at(x0, y0, c) + u * image.at(x1, y0, c)) +
             v * ((1 - u) * image.at(x0, y1, c) + u * image.at(x1, y1, c));
}

void sample_bicubic(const ImageF& image, double x, double y, float* out) {
  const double fx = std::clamp(x - 0.5, 0.0, double(image.width() - 1)),
               fy = std::clamp(y - 0.5, 0.0, double(image.height() - 1));
  const int x0 = int(fx), y0 = int(fy);
  // Catmull-Rom weights of the four taps at -1, 0, 1, 2.
  const auto weights = [](float t, float* w) {
    w[0] = 0.5f * t * (-1 + t * (2 - t));
    w[1] = 1 + 0.5f * t * t * (-5 + 3 * t);
    w[2] = 0.5f * t * (1 + t * (4 - 3 * t));
    w[3] = 0.5f * t * t * (t - 1);
  };
  float wx[4], wy[4];
  weights(float(fx - x0), wx);
  weights(float(fy - y0), wy);
  for (int c = 0; c < image.channels(); ++c) {
    float sum = 0, low = INFINITY, high = -INFINITY;
    for (int j = 0; j < 4; ++j)
      for (int i = 0; i < 4; ++i) {
        const float value =
            image.at(std::clamp(x0 + i - 1, 0, image.width() - 1), std::clamp(y0 + j - 1, 0, image.height() - 1), c);
        sum += wx[i] * wy[j] * value;
        if ((i == 1 || i == 2) && (j == 1 || j == 2)) {
          low = std::min(low, value);
          high = std::max(high, value);
        }
      }
    out[c] = std::clamp(sum, low, high);
  }
}

ImageF upright(const ImageF& stored, int orientation) {
  if (orientation <= 1 || orientation > 8) return stored;
  const int w = stored.width(), h = stored.height(), channels = stored.channels();
  const bool turned = orientation >= 5;
  ImageF out(turned ? h : w, turned ? w : h, channels);
  // Position of row 0 and column 0 of the stored image (EXIF 2.32, tag 0x0112):
  //   1 top left  2 top right  3 bottom right  4 bottom left  5 left top  6 right top  7 right bottom  8 left bottom
  const bool mirror_x = orientation == 2 || orientation == 3 || orientation == 6 || orientation == 7;
  const bool mirror_y = orientation == 3 || orientation == 4 || orientation == 7 || orientation == 8;
  for (int y = 0; y < h; ++y) {
    for (int x = 0; x < w; ++x) {
      const int across = turned ? y : x, down = turned ? x : y;
      const int to_x = mirror_x ? out.width() - 1 - across : across, to_y = mirror_y ? out.height() - 1 - down : down;
      std::copy_n(stored.pixel(x, y), channels, out.pixel(to_x, to_y));
    }
  }
  return out;
}

namespace {
constexpr float kBrightest = 65504.0f;  // half-float maximum, used by the EXR files we write
}

RepairedValues repair_values(ImageF& image, float darkest) {
  RepairedValues r;
  for (float& v : image.data()) {
    if (v >= darkest && v <= kBrightest) continue;
    if (std::isnan(v) || v == -INFINITY)
      ++r.not_numbers, v = 0;
    else if (v > kBrightest)
      ++r.too_bright, v = kBrightest;
    else
      ++r.negative, v = darkest;
  }
  return r;
}

RepairedValues& RepairedValues::operator+=(const RepairedValues& o) {
  not_numbers += o.not_numbers;
  too_bright += o.too_bright;
  negative += o.negative;
  return *this;
}

std::string RepairedValues::text() const {
  std::string out;
  const auto add = [&](size_t n, std::string_view which, std::string_view now) {
    if (n > 0) out += fmt::format("{}{}{} {} to {}", out.empty() ? "" : ", ", n, out.empty() ? " values" : "", which, now);
  };
  add(not_numbers, "that are not numbers were set", "0");
  add(too_bright, out.empty() ? "above 65504 (or infinite) were set" : "above 65504 (or infinite)", "65504");
  add(negative, out.empty() ? "below 0 were set" : "below 0", "0");
  return out;
}

}  // namespace vitrine
