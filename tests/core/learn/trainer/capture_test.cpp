// Photos as training takes them.
#include "core/learn/trainer/capture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace vitrine {
namespace {

TEST(Capture, ColoursOutsideOfRec709AreTrainedOnAsTheNearestInside) {
  View view;
  view.intrinsics = {16, 16, 20, 20, 8, 8};
  ImageF linear(16, 16, 3);
  for (size_t i = 0; i < linear.data().size(); ++i) linear.data()[i] = i % 3 == 0 ? 1.2f : i % 3 == 1 ? -0.2f : 0.5f;
  const PhotoPyramid photo = make_photo(view, linear, 0);
  for (const PhotoLevel& level : photo.levels) {
    const size_t pixels = level.srgb.size() / 3;
    EXPECT_EQ(level.srgb[0], 65535);
    EXPECT_EQ(level.srgb[pixels], 0);
    std::vector<float> srgb;
    decode(level, srgb);
    for (float v : srgb) EXPECT_TRUE(v >= 0 && v <= 1);
    for (size_t c = 0; c < 3; ++c) EXPECT_TRUE(std::isfinite(linear_at(level, 0)[c]));
  }
}

TEST(Capture, ClippedChannelsAreLowerBounds) {
  const std::vector<float> prediction{1.0f, 0.5f, 0.99f, 1.0f, 0.2f};
  std::vector<float> target{0.98f, 1.0f, 0.97f, 0.5f, 0.4f};  // clipped, clipped, not, not, not
  raise_clipped(prediction, target);
  EXPECT_EQ(target, (std::vector<float>{1.0f, 1.0f, 0.97f, 0.5f, 0.4f}));
}

}  // namespace
}  // namespace vitrine
