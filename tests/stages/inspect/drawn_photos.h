// Photos drawn for tests: rectangles of random grey, smeared by known amounts.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/foundation/base/rng.h"
#include "core/scene/image/image.h"

namespace vitrine::test {

// Mean over `samples` pictures shifted along (dx, dy) by Gaussian or uniform steps would be slow; two passes of weights do.
inline Image8 smeared(const Image8& in, double sigma_x, double sigma_y) {
  const auto pass = [](const ImageF& from, double sigma, int dx, int dy) {
    if (sigma <= 0) return from;
    ImageF to(from.width(), from.height(), 3, 0.0f);
    const int r = int(std::ceil(3 * sigma));
    double sum = 0;
    for (int i = -r; i <= r; ++i) sum += std::exp(-0.5 * i * i / (sigma * sigma));
    for (int y = 0; y < from.height(); ++y)
      for (int x = 0; x < from.width(); ++x)
        for (int i = -r; i <= r; ++i) {
          const int sx = std::clamp(x + i * dx, 0, from.width() - 1), sy = std::clamp(y + i * dy, 0, from.height() - 1);
          for (int c = 0; c < 3; ++c)
            to.at(x, y, c) += float(std::exp(-0.5 * i * i / (sigma * sigma)) / sum) * from.at(sx, sy, c);
        }
    return to;
  };
  ImageF image(in.width(), in.height(), 3);
  std::copy(in.data().begin(), in.data().end(), image.data().begin());
  image = pass(pass(image, sigma_x, 1, 0), sigma_y, 0, 1);
  Image8 out(in.width(), in.height(), 3);
  std::transform(image.data().begin(), image.data().end(), out.data().begin(), [](float v) { return uint8_t(v + 0.5f); });
  return out;
}

// `shift` moves all rectangles to the left: another view of the same wall.
inline Image8 wall(int width, int height, uint64_t seed, int shift = 0, double brightness = 1) {
  Image8 image(width, height, 3, uint8_t(128 * brightness));
  for (uint64_t i = 0; i < 220; ++i) {
    Rng rng(seed, i);
    const int left = int(rng.uniform_double() * 2 * width) - shift, top = int(rng.uniform_double() * height) - 8;
    const int w = 12 + int(rng.uniform_double() * 50), h = 12 + int(rng.uniform_double() * 50);
    const double grey = 30 + 200 * rng.uniform_double();
    for (int y = std::max(top, 0); y < std::min(top + h, height); ++y)
      for (int x = std::max(left, 0); x < std::min(left + w, width); ++x)
        for (int c = 0; c < 3; ++c) image.at(x, y, c) = uint8_t(std::clamp(grey * brightness, 0.0, 255.0));
  }
  return image;
}

}  // namespace vitrine::test
