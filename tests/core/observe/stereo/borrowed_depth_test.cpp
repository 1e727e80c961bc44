#include "core/observe/stereo/borrowed_depth.h"

#include <vector>

#include <gtest/gtest.h>

namespace vitrine {
namespace {

TEST(BorrowedDepth, IsTheMeanInverseOfTheThreeNearest) {
  const std::vector<PixelDepth> known{{9, 0, 50}, {3, 0, 2}, {0, 1, 4}, {-2, 0, 4}};
  const auto found = borrowed_depth(known, 0, 0, 5);
  ASSERT_TRUE(found.has_value());
  const double weights = 1 / 2.0 + 1 / 5.0 + 1 / 10.0;
  EXPECT_DOUBLE_EQ(found->z, weights / ((1 / 2.0 + 1 / 5.0) / 4 + 1 / 10.0 / 2));
  EXPECT_EQ(found->spread, 2);
}

TEST(BorrowedDepth, OfFewerIsThatOfThose) {
  const auto one = borrowed_depth(std::vector<PixelDepth>{{3, 4, 7}}, 0, 0, 5);
  ASSERT_TRUE(one.has_value());
  EXPECT_DOUBLE_EQ(one->z, 7);
  EXPECT_EQ(one->spread, 1);
  EXPECT_FALSE(borrowed_depth(std::vector<PixelDepth>{{3, 4, 7}}, 0, 0, 4.9));  // out of reach
  EXPECT_FALSE(borrowed_depth({}, 0, 0, 5));
  EXPECT_FALSE(borrowed_depth(std::vector<PixelDepth>{{0, 0, -1}, {0, 0, 0}}, 0, 0, 5)) << "behind the camera nothing is known";
}

}  // namespace
}  // namespace vitrine
