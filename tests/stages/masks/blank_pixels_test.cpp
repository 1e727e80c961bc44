// What lies outside the alpha of cut-out photos.
#include "stages/masks/proposed/blank_pixels.h"

#include <gtest/gtest.h>

namespace vitrine {
namespace {

constexpr int kSide = 40;

// Black, with a square of changing colours in the middle.
SmallPhoto framed(float ground) {
  SmallPhoto photo;
  photo.view.intrinsics = {kSide, kSide, 40, 40, 20, 20};
  photo.srgb.assign(3 * kSide * kSide, ground);
  for (int c = 0; c < 3; ++c)
    for (int y = 10; y < 30; ++y)
      for (int x = 10; x < 30; ++x) photo.srgb[size_t((c * kSide + y) * kSide + x)] = 0.2f + 0.02f * float(x + c * y / 2);
  return photo;
}

TEST(BlankPixels, AreTheGroundOfOneColourAndTwoPixelsAround) {
  for (const float ground : {0.f, 1.f}) {
    const std::vector<uint8_t> blank = blank_pixels(framed(ground));
    const auto at = [&](int x, int y) { return blank[size_t(y * kSide + x)]; };
    EXPECT_EQ(at(0, 0), 1) << ground;
    EXPECT_EQ(at(5, 20), 1) << ground;
    EXPECT_EQ(at(11, 20), 1) << "two pixels of the outline are mixed";
    EXPECT_EQ(at(13, 20), 0);
    EXPECT_EQ(at(20, 20), 0);
  }
}

TEST(BlankPixels, PhotosWithoutAGroundHaveNone) {
  SmallPhoto photo = framed(0);
  for (size_t i = 0; i < photo.srgb.size(); ++i) photo.srgb[i] = float(i % 97) / 97;
  for (const uint8_t blank : blank_pixels(photo)) EXPECT_EQ(blank, 0);
}

TEST(BlankPixels, ASpeckOfTheGroundsColourInsideIsShown) {
  SmallPhoto photo = framed(0);
  for (int c = 0; c < 3; ++c) photo.srgb[size_t((c * kSide + 20) * kSide + 20)] = 0;
  EXPECT_EQ(blank_pixels(photo)[20 * kSide + 20], 0);
}

}  // namespace
}  // namespace vitrine
