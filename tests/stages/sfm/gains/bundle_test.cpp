// A bundle adjustment in which each photo has its own focal length.
#include "stages/sfm/gains/bundle.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/stages/sfm/gains/ring_of_photos.h"

namespace vitrine {
namespace {

constexpr double kNoise = 0.3;  // pixels

// Photos on a ring around a cloud of points, every second one with `second` pixels of focal length, as one camera of 500 pixels
// sees them.
ColmapModel ring(double first, double second) {
  Rng rng(5);
  ColmapModel model;
  model.cameras.push_back({.id = 1, .model_id = 2, .width = 640, .height = 480, .params = {500, 320, 240, 0}});
  test::add_cloud(model, 300, rng);
  for (uint32_t v = 1; v <= 12; ++v) {
    const double focal = v % 2 == 0 ? second : first;
    test::add_photo(model, v, 2 * std::numbers::pi * v / 12, 0.5 + 0.3 * (v % 3), [&](double x, double y) {
      return Vec2d{focal * x + 320 + kNoise * rng.normal(), focal * y + 240 + kNoise * rng.normal()};
    });
  }
  return model;
}

TEST(BundleAdjustment, FindsTheFocalLengthOfEachPhoto) {
  ColmapModel model = ring(450, 600), again = model;
  BundleAdjustment adjustment(model, BundleAdjustment::Focals::OfPhotos);
  EXPECT_GT(adjustment.error(), 3);
  EXPECT_NEAR(adjustment.solve(false), kNoise * std::sqrt(2.0), 0.05);
  const std::vector<double> focals = adjustment.focals();
  for (size_t i = 0; i < focals.size(); ++i) EXPECT_NEAR(focals[i], i % 2 == 1 ? 600 : 450, 12) << i;
  BundleAdjustment second(again, BundleAdjustment::Focals::OfPhotos);
  second.solve(false);
  EXPECT_EQ(second.focals(), focals) << "the same bytes";
}

TEST(BundleAdjustment, OneFocalLengthStaysOneWithinAFewPerCent) {
  ColmapModel model = ring(500, 500), common = model;
  BundleAdjustment one(common);
  const double before = one.solve(false);
  BundleAdjustment own(model, BundleAdjustment::Focals::OfPhotos);
  EXPECT_GT(own.solve(false), 0.97 * before) << "nothing to explain";
  for (const double f : own.focals()) EXPECT_NEAR(f, 500, 15);
}

TEST(BundleAdjustment, FewStepsAreContinued) {
  ColmapModel model = ring(450, 600);
  BundleAdjustment adjustment(model, BundleAdjustment::Focals::OfPhotos);
  const double before = adjustment.error(), first = adjustment.solve(false, 2), then = adjustment.solve(false);
  EXPECT_LT(first, before);
  EXPECT_LT(then, first);
}

}  // namespace
}  // namespace vitrine
