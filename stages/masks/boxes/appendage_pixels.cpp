#include "stages/masks/boxes/outlines.h"

#include <algorithm>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

namespace vitrine {

namespace {

constexpr float kRoot = 1.25f;      // path to the body at most this factor longer than the straight one: a connection
constexpr float kRootSlack = 1.5f;  // pixels

struct Nearest {                // nearest pixel of a set
  std::vector<float> distance;  // pixels
  std::vector<uint32_t> pixel;
};
Nearest nearest_of(const std::vector<uint8_t>& set, const Intrinsics& k) {
  cv::Mat outside(k.height, k.width, CV_8UC1), distance, label;
  for (size_t i = 0; i < set.size(); ++i) outside.data[i] = set[i] ? 0 : 1;
  cv::distanceTransform(outside, distance, label, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  Nearest out{{distance.begin<float>(), distance.end<float>()}, std::vector<uint32_t>(set.size())};
  const auto labels = label.begin<int32_t>();
  std::vector<uint32_t> pixel_of(set.size() + 1, 0);
  for (size_t i = 0; i < set.size(); ++i)
    if (set[i]) pixel_of[size_t(labels[ptrdiff_t(i)])] = uint32_t(i);
  for (size_t i = 0; i < set.size(); ++i) out.pixel[i] = pixel_of[size_t(labels[ptrdiff_t(i)])];
  return out;
}

}  // namespace

std::vector<uint8_t> with_appendages(const std::vector<uint8_t>& solid, const std::vector<uint8_t>& off,
                                     const std::vector<uint8_t>& far, const Intrinsics& k) {
  std::vector<uint8_t> out = solid;
  const auto any = [](const std::vector<uint8_t>& set) { return std::ranges::any_of(set, [](uint8_t v) { return v != 0; }); };
  if (!any(far)) return out;
  if (!any(solid)) {  // only the appendage is visible
    for (size_t p = 0; p < out.size(); ++p) out[p] = off[p] && far[p];
    return out;
  }
  const Nearest to_far = nearest_of(far, k), to_solid = nearest_of(solid, k);
  for (size_t p = 0; p < out.size(); ++p) {
    const float straight = to_solid.distance[to_far.pixel[p]];
    if (off[p] && to_far.distance[p] + to_solid.distance[p] <= kRoot * straight + kRootSlack) out[p] = 1;
  }
  return out;
}

}  // namespace vitrine
