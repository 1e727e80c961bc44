#include "stages/normals/space.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/support/error_of.h"

namespace vitrine {
namespace {

View view_of(int width, int height) {
  View v;
  v.intrinsics = {width, height, double(width), double(width), width / 2.0, height / 2.0};
  return v;
}

TEST(NormalSpace, AWallInFrontOfEveryCameraLeavesSignsOpen) {
  const View view = view_of(40, 30);
  NormalMap wall(40, 30);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 40; ++x) wall.set(x, y, {0, 0, -1}, 1);
  const Error e = error_of([&] { detected_space(std::vector<SpaceSample>{{wall, wall, view}}, "maps"); });
  EXPECT_EQ(e.detail().code, "AMBIGUOUS_NORMAL_SPACE");
  EXPECT_NE(e.detail().why.find("fit alike"), std::string::npos) << e.detail().why;
}

TEST(NormalSpace, ABallDecidesAllSigns) {
  const View view = view_of(60, 60);
  NormalMap ball(60, 60), given(60, 60);
  for (int y = 0; y < 60; ++y)
    for (int x = 0; x < 60; ++x) {
      const float u = float(x - 29.5) / 30, v = float(y - 29.5) / 30, r = u * u + v * v;
      if (r >= 0.7f) continue;
      ball.set(x, y, {u, v, -std::sqrt(1 - r)}, 1);
      given.set(x, y, {u, -v, std::sqrt(1 - r)}, 1);
    }
  const auto found = detected_space(std::vector<SpaceSample>{{given, ball, view}}, "maps");
  EXPECT_EQ(found[0].space.name(), "camera-opengl");
  EXPECT_NEAR(found[0].error_deg, 0, 0.1);
  EXPECT_EQ(found.size(), 9u);
}

TEST(NormalSpace, TooFewPixelsAreNoEvidence) {
  const View view = view_of(60, 60);
  NormalMap few(60, 60);
  for (int x = 0; x < 60; ++x) few.set(x, 3, normalized(Vec3f{float(x - 30), 10, -30}), 1);
  const Error e = error_of([&] { detected_space(std::vector<SpaceSample>{{few, few, view}}, "maps"); });
  EXPECT_NE(e.detail().why.find("pixels"), std::string::npos);
}

TEST(NormalMap, ReducingAveragesByConfidence) {
  NormalMap map(4, 2);
  map.set(0, 0, {0, 0, -1}, 1);
  map.set(1, 0, normalized(Vec3f{1, 0, -1}), 0.25f);
  map.set(2, 0, {1, 0, 0}, 1);  // two that cancel
  map.set(3, 0, {-1, 0, 0}, 1);
  const NormalMap half = resized(map, 2, 1);
  const Vec3f expected = normalized(Vec3f{0, 0, -1} + 0.25f * normalized(Vec3f{1, 0, -1}));
  EXPECT_NEAR(dot(half.at(0, 0), expected), 1, 1e-6);
  EXPECT_GT(half.confidence.at(0, 0), 0.2f);
  EXPECT_LE(half.confidence.at(0, 0), 1.25f / 4 + 1e-6f);
  EXPECT_EQ(half.at(1, 0), (Vec3f{0, 0, 0}));
  EXPECT_EQ(half.confidence.at(1, 0), 0);
}

TEST(NormalMap, NormalsThatLookAwayAreForgotten) {
  NormalMap map(2, 1);
  map.set(0, 0, {0, 0, -1}, 1);
  map.set(1, 0, {0, 0, 1}, 1);
  const Facing facing = forget_hidden_sides(map, view_of(2, 1).intrinsics);
  EXPECT_EQ(facing.known, 2u);
  EXPECT_EQ(facing.away, 1u);
  EXPECT_EQ(map.confidence.at(1, 0), 0);
  EXPECT_EQ(map.at(0, 0).z, -1);
}

}  // namespace
}  // namespace vitrine
