#include "core/math/point_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "core/base/rng.h"

namespace vitrine {
namespace {

TEST(PointGrid, AgreesWithASearchThroughAll) {
  Rng rng(3);
  std::vector<Vec3f> points(500);
  for (Vec3f& p : points) p = {rng.uniform(), rng.uniform(), 0.2f * rng.uniform()};
  const PointGrid grid(points, 0.05f);
  for (int trial = 0; trial < 50; ++trial) {
    const Vec3f q{1.2f * rng.uniform(), rng.uniform(), 0.3f * rng.uniform()};
    std::vector<std::pair<float, uint32_t>> all;
    for (size_t i = 0; i < points.size(); ++i)
      if (const float d = squared_length(points[i] - q); d <= 0.09f) all.emplace_back(d, uint32_t(i));
    std::ranges::sort(all);
    std::vector<PointGrid::Near> near;
    grid.nearest(q, 7, 0.3f, near);
    ASSERT_EQ(near.size(), std::min<size_t>(7, all.size()));
    for (size_t k = 0; k < near.size(); ++k) EXPECT_EQ(near[k].index, all[k].second);
    EXPECT_EQ(grid.any(q, 0.3f), !all.empty());
    EXPECT_EQ(grid.any(q, 0.02f), !all.empty() && all.front().first <= 0.02f * 0.02f);
  }
}

TEST(PointGrid, HasNoPointNearWhatIsNoNumber) {
  const std::vector<Vec3f> points{{0, 0, 0}};
  const PointGrid grid(points, 0.1f);
  EXPECT_FALSE(grid.any({std::numeric_limits<float>::quiet_NaN(), 0, 0}, 1));
  EXPECT_FALSE(grid.any({std::numeric_limits<float>::infinity(), 0, 0}, 1));
}

}  // namespace
}  // namespace vitrine
