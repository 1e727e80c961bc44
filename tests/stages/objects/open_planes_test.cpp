// Which rectangles are found in masks, and which are left to the hulls of closed objects.
#include "stages/objects/detect.h"

#include <gtest/gtest.h>

#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

constexpr double kFullTurn = 2 * std::numbers::pi;
const Plane kMirror{{-0.8, 0, 0.1}, Mat3d{{0, 1, 0}, {0, 0, 1}, {1, 0, 0}}, {0.3, 0.2}};
const Vec3d kBall{0.3, 0.2, -0.25};

std::vector<Silhouette> mirror_on_a_wall_and_a_ball() {
  return silhouettes_of_rays(30, kFullTurn, [](const Vec3d& eye, const Vec3d& d) {
    const auto hit = kMirror.intersect({eye, d});
    return (hit && hit->element == 0) || meets_ball(kBall, 0.12, eye, d);
  });
}

TEST(OpenPlanes, AMirrorOnAWallIsOneAndABallIsNone) {
  const auto silhouettes = mirror_on_a_wall_and_a_ball();
  const ShapeSet found = open_planes(MaskClass::Specular, silhouettes, {}, true);
  ASSERT_EQ(found.entries.size(), 1u);
  EXPECT_EQ(found.entries[0].role, ShapeRole::Mirror);
  EXPECT_GT(dot(std::get<Plane>(found.entries[0].shape).axes.c2, kMirror.axes.c2), 0.999);
  EXPECT_TRUE(open_planes(MaskClass::Specular, unexplained(silhouettes, found), {}, false).entries.empty());
}

TEST(OpenPlanes, WhatPhotosFromBehindSeeAsWellHangsOnNoWall) {
  const Plane pane{{0, 0, 0}, kMirror.axes, {0.3, 0.25}};
  const auto silhouettes = silhouettes_of_rays(30, kFullTurn, [&](const Vec3d& eye, const Vec3d& d) {
    return pane.intersect({eye, d}).has_value();
  });
  EXPECT_TRUE(open_planes(MaskClass::Transparent, silhouettes, {}, true).entries.empty());
  const ShapeSet found = open_planes(MaskClass::Transparent, silhouettes, {}, false);
  ASSERT_FALSE(found.entries.empty());
  EXPECT_EQ(found.entries[0].role, ShapeRole::Sheet);
  EXPECT_GT(std::abs(std::get<Plane>(found.entries[0].shape).axes.c2.x), 0.999);
}

TEST(OpenPlanes, PixelsOfFoundShapesAreUnknown) {
  const auto silhouettes = mirror_on_a_wall_and_a_ball();
  const ShapeSet found{.entries = {{kMirror, ShapeRole::Mirror, 0.01, -1, {}}}};
  const auto rest = unexplained(silhouettes, found);
  size_t unknown = 0, marked = 0;
  for (size_t v = 0; v < rest.size(); ++v)
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 96; ++x) {
        const View& view = rest[v].view;
        const Ray ray{view.centre_in_world(), view.ray(x + 0.5, y + 0.5)};
        if (kMirror.intersect(ray)) {
          EXPECT_LT(rest[v].value.at(x, y), 0);
          ++unknown;
        } else {
          marked += rest[v].value.at(x, y) >= 0.5f;
        }
      }
  EXPECT_GT(unknown, 1000u);
  EXPECT_GT(marked, 1000u) << "the ball is still there";
}

}  // namespace
}  // namespace vitrine
