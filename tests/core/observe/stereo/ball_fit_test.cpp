// Balls among surfaces of revolution.
#include "core/observe/stereo/shape_fit.h"

#include <gtest/gtest.h>

#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

const Vec3d kMiddle{0.02, -0.03, 0.05};
constexpr double kSphere = 0.2;

// As a free profile comes out of photos that look down: cones for the top and the foot, and noise.
SurfaceOfRevolution with_cones() {
  SurfaceOfRevolution s{{kMiddle.x, kMiddle.y, 0}, {0, 0, 1}, {{0, -0.19}}};
  for (int i = 0; i <= 40; ++i) {
    const double h = kMiddle.z + kSphere * (i / 20.0 - 1) * 0.85, away = h - kMiddle.z;
    s.profile.push_back({std::sqrt(kSphere * kSphere - away * away) + 0.001 * std::sin(5.0 * i), h});
  }
  s.profile.push_back({0, 0.29});
  return s;
}

TEST(BallFit, FindsTheSphereBetweenTheCones) {
  const auto masks = silhouettes_of_rays(24, 2 * std::numbers::pi,
                                         [](const Vec3d& eye, const Vec3d& d) { return meets_ball(kMiddle, kSphere, eye, d); });
  const auto ball = ball_of(masks, with_cones());
  ASSERT_TRUE(ball);
  for (const Vec2d& p : ball->profile) EXPECT_NEAR(std::hypot(p.x, p.y - kMiddle.z), kSphere, 0.002);
  EXPECT_NEAR(ball->profile.front().y, kMiddle.z - kSphere, 0.002);
}

// A third of the photos see its foot hidden by something.
TEST(BallFit, IsNotDisturbedByWhatStandsBefore) {
  auto masks = silhouettes_of_rays(24, 2 * std::numbers::pi,
                                   [](const Vec3d& eye, const Vec3d& d) { return meets_ball(kMiddle, kSphere, eye, d); });
  for (size_t v = 0; v < masks.size(); v += 3)
    for (int y = 46; y < masks[v].value.height(); ++y)
      for (int x = 0; x < masks[v].value.width(); ++x) masks[v].value.at(x, y) = 0;
  EXPECT_TRUE(ball_of(masks, with_cones()));
}

TEST(BallFit, AJarAndADomeAreNone) {
  const auto jar_masks = silhouettes_of_rays(24, 2 * std::numbers::pi,
                                             [](const Vec3d& eye, const Vec3d& d) { return meets_cylinder(0.15, 0.2, eye, d); });
  SurfaceOfRevolution jar{{0, 0, 0}, {0, 0, 1}, {{0, -0.2}}};
  for (int i = 0; i <= 40; ++i) jar.profile.push_back({0.15, -0.2 + 0.01 * i});
  jar.profile.push_back({0, 0.2});
  EXPECT_FALSE(ball_of(jar_masks, jar));
  // A ball that is cut off below its middle.
  const auto cut = [](const Vec3d& eye, const Vec3d& d) {
    for (int i = 0; i < 300; ++i) {
      const Vec3d p = eye + (0.6 + 0.8 * i / 300) * d;
      if (p.z > kMiddle.z - 0.02 && length(p - kMiddle) < kSphere) return true;
    }
    return false;
  };
  SurfaceOfRevolution dome{{kMiddle.x, kMiddle.y, 0}, {0, 0, 1}, {{0, kMiddle.z - 0.02}}};
  for (int i = 0; i <= 40; ++i) {
    const double away = -0.02 + 0.22 * i / 40;
    dome.profile.push_back({std::sqrt(std::max(0.0, kSphere * kSphere - away * away)), kMiddle.z + away});
  }
  EXPECT_FALSE(ball_of(silhouettes_of_rays(24, 2 * std::numbers::pi, cut), dome));
}

}  // namespace
}  // namespace vitrine
