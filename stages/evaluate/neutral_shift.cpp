#include "stages/evaluate/neutral_shift.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/error.h"
#include "core/math/color.h"
#include "core/math/median.h"
#include "core/math/vec.h"

namespace vitrine {

namespace {

// sRGB values of a photo.
constexpr float kBright = 0.5f;
constexpr float kNeutral = 0.03f;  // between two channels of a pixel: 5 to 7 % in linear light
constexpr float kPlain = 0.04f;    // between two pixels of the neighbourhood, in any channel: noise and JPEG, no texture
constexpr int kRadius = 2;         // of the neighbourhood
constexpr double kBlack = 1e-3;    // of a render in linear light: its logarithm stays finite

bool plain_and_neutral(const ImageF& photo, const ImageF& counts, int x, int y) {
  const float* middle = photo.pixel(x, y);
  const auto [least, most] = std::minmax({middle[0], middle[1], middle[2]});
  if (least < kBright || most - least > kNeutral) return false;
  float low[3] = {1, 1, 1}, high[3] = {0, 0, 0};
  for (int v = y - kRadius; v <= y + kRadius; ++v) {
    for (int u = x - kRadius; u <= x + kRadius; ++u) {
      if (counts.at(u, v) == 0) return false;
      for (int c = 0; c < 3; ++c) {
        low[c] = std::min(low[c], photo.at(u, v, c));
        high[c] = std::max(high[c], photo.at(u, v, c));
        if (high[c] - low[c] > kPlain) return false;
      }
    }
  }
  return true;
}

}  // namespace

std::optional<double> neutral_shift(const ImageF& srgb, const ImageF& photo, const ImageF& counts, int min_pixels) {
  VITRINE_CHECK(srgb.width() == photo.width() && srgb.height() == photo.height() && counts.width() == photo.width() &&
                    counts.height() == photo.height(),
                "pictures of different size");
  std::vector<double> log_ratio[3];
  for (int y = kRadius; y < photo.height() - kRadius; ++y)
    for (int x = kRadius; x < photo.width() - kRadius; ++x) {
      if (!plain_and_neutral(photo, counts, x, y)) continue;
      for (int c = 0; c < 3; ++c) {
        const double render = linear_from_srgb(static_cast<double>(srgb.at(x, y, c)));
        log_ratio[c].push_back(std::log(std::max(render, kBlack) / linear_from_srgb(static_cast<double>(photo.at(x, y, c)))));
      }
    }
  if (log_ratio[0].empty() || log_ratio[0].size() < static_cast<size_t>(std::max(min_pixels, 0))) return std::nullopt;
  double median[3];
  for (int c = 0; c < 3; ++c) median[c] = upper_median(std::move(log_ratio[c]));
  const auto [least, most] = std::minmax({median[0], median[1], median[2]});
  return std::exp(most - least) - 1;
}

}  // namespace vitrine
