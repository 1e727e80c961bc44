#include "core/observe/stereo/visual_hull.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/core/observe/stereo/silhouettes_of_rays.h"

namespace vitrine {
namespace {

constexpr double kRadius = 0.25;
const Vec3d kCentre{0.05, -0.1, 0.1};

std::vector<Silhouette> ball_masks(int count, double span_rad, const Vec3d& centre = kCentre, double radius = kRadius) {
  return silhouettes_of_rays(count, span_rad,
                             [&](const Vec3d& eye, const Vec3d& d) { return meets_ball(centre, radius, eye, d); });
}

TEST(VisualHull, OfABallHasTheBallsNormals) {
  const std::vector<Silhouette> masks = ball_masks(24, 2 * std::numbers::pi);
  const VisualHull hull(masks, {.resolution = 64, .rule = {.outlier_share = 0}});
  ASSERT_FALSE(hull.empty());
  EXPECT_LT(hull.one_sidedness(), 0.5);
  double angle = 0, distance = 0;
  size_t hits = 0;
  const View& view = masks[1].view;
  const Vec3d eye = view.centre_in_world();
  for (int y = 0; y < 80; y += 2)
    for (int x = 0; x < 96; x += 2) {
      const Vec3d d = normalized(view.ray(x + 0.5, y + 0.5));
      const auto hit = hull.first_hit(eye, d);
      const Vec3d to = kCentre - eye;
      const double off = length(to - dot(to, d) * d);
      EXPECT_FALSE(hit && off > kRadius * 1.2) << x << " " << y;
      if (off > kRadius * 0.85) continue;
      ASSERT_TRUE(hit) << x << " " << y;
      const Vec3d p = eye + hit->t * d;
      distance += std::abs(length(p - kCentre) - kRadius);
      angle += std::acos(std::min(1.0, dot(hit->normal, normalized(p - kCentre)))) * 57.29578;
      ++hits;
    }
  EXPECT_LT(angle / double(hits), 9);
  EXPECT_LT(distance / double(hits), 0.03);
}

TEST(VisualHull, IsAsLargeAsTheBall) {
  for (int resolution : {24, 64}) {
    const Bounds3 bounds =
        VisualHull(ball_masks(24, 2 * std::numbers::pi), {.resolution = resolution, .rule = {.outlier_share = 0}}).bounds();
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_LT(std::abs(bounds.centre()[i] - kCentre[i]), 0.03);
      EXPECT_NEAR(bounds.high[i] - bounds.low[i], 2 * kRadius, 0.06) << resolution;
    }
  }
}

TEST(VisualHull, OfOnePieceKeepsTheLargestPart) {
  std::vector<Silhouette> masks = ball_masks(24, 2 * std::numbers::pi);
  const std::vector<Silhouette> crumb = ball_masks(24, 2 * std::numbers::pi, {-0.35, 0.3, -0.2}, 0.08);
  for (size_t i = 0; i < masks.size(); ++i)
    for (size_t p = 0; p < masks[i].value.data().size(); ++p) masks[i].value.data()[p] += crumb[i].value.data()[p];
  const View& view = masks[1].view;
  const auto shows = [&](const VisualHull& hull, const Vec3d& point) {
    const Vec3d eye = view.centre_in_world();
    return hull.first_hit(eye, point - eye).has_value();
  };
  const HullDesc all{.resolution = 64, .rule = {.outlier_share = 0}},
      one{.resolution = 64, .rule = {.outlier_share = 0}, .one_piece = true};
  EXPECT_TRUE(shows(VisualHull(masks, all), {-0.35, 0.3, -0.2}));
  EXPECT_FALSE(shows(VisualHull(masks, one), {-0.35, 0.3, -0.2}));
  EXPECT_TRUE(shows(VisualHull(masks, one), kCentre));
}

TEST(VisualHull, AFewPhotosWithSomethingInFrontDoNotCutItAway) {
  std::vector<Silhouette> masks = ball_masks(24, 2 * std::numbers::pi);
  for (size_t m : {3, 11})
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 48; ++x) masks[m].value.at(x, y) = 0;
  const double whole = VisualHull(ball_masks(24, 2 * std::numbers::pi), {.resolution = 48}).bounds().diagonal();
  EXPECT_NEAR(VisualHull(masks, {.resolution = 48, .rule = {.outlier_share = 0.1}}).bounds().diagonal(), whole, 0.1 * whole);
  EXPECT_LT(VisualHull(masks, {.resolution = 48, .rule = {.outlier_share = 0}}).bounds().diagonal(), 0.9 * whole);
}

TEST(VisualHull, PhotosThatDoNotSayCutNothingAway) {
  const double whole = VisualHull(ball_masks(24, 2 * std::numbers::pi), {.resolution = 48}).bounds().diagonal();
  const HullDesc desc{.resolution = 48, .rule = {.outlier_share = 0.1}};
  std::vector<Silhouette> glass = ball_masks(24, 2 * std::numbers::pi), empty = glass;
  for (size_t m = 0; m < glass.size(); m += 3)  // half of the ball, in a third of the photos
    for (int y = 0; y < 80; ++y)
      for (int x = 0; x < 48; ++x) glass[m].value.at(x, y) = -1, empty[m].value.at(x, y) = 0;
  EXPECT_NEAR(VisualHull(glass, desc).bounds().diagonal(), whole, 0.1 * whole);
  EXPECT_LT(VisualHull(empty, desc).bounds().diagonal(), 0.9 * whole);
}

TEST(VisualHull, OfPhotosFromOneSideIsNone) {
  const VisualHull hull(ball_masks(12, 0.5), {.resolution = 48});
  EXPECT_TRUE(hull.empty());
  EXPECT_GT(hull.one_sidedness(), 0.8);
  EXPECT_FALSE(hull.first_hit({1, 0, 0}, {-1, 0, 0}));
}

TEST(VisualHull, OfEmptyOrContradictingMasksIsNone) {
  std::vector<Silhouette> masks = ball_masks(9, 2 * std::numbers::pi);
  EXPECT_TRUE(VisualHull(std::vector<Silhouette>{}, {}).empty());
  for (Silhouette& m : masks) std::fill(m.value.data().begin(), m.value.data().end(), 0.f);
  EXPECT_TRUE(VisualHull(masks, {}).empty());
}

}  // namespace
}  // namespace vitrine
