#include "stages/masks/proposed/blank_pixels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <opencv2/imgproc.hpp>

namespace vitrine {

std::vector<uint8_t> blank_pixels(const SmallPhoto& photo) {
  constexpr float kSame = 1.5f / 255;  // half-precision files and the division by gains keep a colour to less than that
  constexpr double kLeastBorder = 0.1;
  const Intrinsics& k = photo.view.intrinsics;
  const size_t pixels = k.pixel_count();
  const auto colour = [&](size_t i) { return std::array{photo.srgb[i], photo.srgb[pixels + i], photo.srgb[2 * pixels + i]}; };
  std::map<std::array<int, 3>, std::vector<size_t>> border;
  size_t all = 0;
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; x += y == 0 || y == k.height - 1 ? 1 : std::max(k.width - 1, 1)) {
      const std::array<float, 3> c = colour(k.index(x, y));
      border[{int(c[0] * 255 + 0.5f), int(c[1] * 255 + 0.5f), int(c[2] * 255 + 0.5f)}].push_back(k.index(x, y));
      ++all;
    }
  const auto commonest = std::ranges::max_element(border, {}, [](const auto& entry) { return entry.second.size(); });
  std::vector<uint8_t> blank(pixels, 0);
  if (commonest == border.end() || double(commonest->second.size()) < kLeastBorder * double(all)) return blank;
  const std::array<float, 3> ground = colour(commonest->second[0]);
  for (size_t i = 0; i < pixels; ++i) {
    const std::array<float, 3> c = colour(i);
    blank[i] = std::abs(c[0] - ground[0]) < kSame && std::abs(c[1] - ground[1]) < kSame && std::abs(c[2] - ground[2]) < kSame;
  }
  cv::Mat map(k.height, k.width, CV_8U, blank.data());
  cv::erode(map, map, cv::Mat::ones(3, 3, CV_8U), {-1, -1}, 1, cv::BORDER_REPLICATE);
  cv::dilate(map, map, cv::Mat::ones(7, 7, CV_8U), {-1, -1}, 1, cv::BORDER_REPLICATE);
  return blank;
}

}  // namespace vitrine
