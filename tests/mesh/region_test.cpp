#include "stages/mesh/region.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/error.h"
#include "core/base/rng.h"
#include "core/camera/view_set.h"
#include "tests/mesh/orbit.h"

namespace vitrine {
namespace {

TEST(Region, WideCaptureKeepsAllButOutliers) {
  ViewSet set;
  for (int i = 0; i < 20; ++i) {  // a street: side by side, looking ahead
    View v;
    v.intrinsics = {100, 100, 100, 100, 50, 50};
    v.cam_from_world = orbit::looking_at({0.1 * i - 1, 0, 0}, {0.1 * i - 1, 10, 0});
    set.views.push_back(v);
  }
  Rng rng(4);
  for (int i = 0; i < 1000; ++i) set.points.push_back({{4 * rng.uniform() - 2, 3 + 2 * rng.uniform(), rng.uniform()}, {}, 0, {}});
  set.points.push_back({{500, 900, 3}, {}, 0, {}});
  const Region region = scene_region(set, {});
  EXPECT_FALSE(region.convergent);
  EXPECT_NEAR(region.box.low.x, -2, 0.6);
  EXPECT_NEAR(region.box.high.y, 5, 0.6);
  set.points.resize(5);
  EXPECT_THROW(scene_region(set, {}), Error);
}

TEST(Region, WithoutPointsItLiesBetweenCamerasThatLookAtOnePlace) {
  ViewSet set;
  const Vec3d target{1, 2, 3};
  for (int i = 0; i < 8; ++i) {
    View v;
    v.intrinsics = {100, 100, 100, 100, 50, 50};
    v.cam_from_world = orbit::looking_at(target + Vec3d{2 * std::cos(0.7 * i), 2 * std::sin(0.7 * i), 0}, target);
    set.views.push_back(v);
  }
  const Region region = scene_region(set, {});
  EXPECT_TRUE(region.convergent);
  EXPECT_EQ(region.points, 0u);
  for (size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR((region.box.low[axis] + region.box.high[axis]) / 2, target[axis], 1e-9);
  EXPECT_NEAR(length(region.box.high - target), 2, 1e-9);  // its corners are as far away as the cameras
}
}  // namespace
}  // namespace vitrine
