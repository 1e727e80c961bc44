// A painted ball inside a ball of clear glass.
#include "core/relight/relit_painter.h"

#include <gtest/gtest.h>

#include "tests/core/relight/relit_ball.h"

namespace vitrine {
namespace {

TEST(GlassContent, FollowsTheLightThatReachesItThroughTheGlass) {
  for (const Glass glass : {Glass::Thin, Glass::Traced}) {
    RelitPainter painter(test::ball_in_glass(glass));
    const auto middle = [&](const Lighting& light) {
      painter.set_lighting(light);
      return painter.picture(test::view_from({1, 0, 0}), {.samples = 4}).radiance;
    };
    // The light of the photos shows the trained colour; twice the light, twice the colour.
    const ImageF before = middle(test::constant_light(1)), twice = middle(test::constant_light(2));
    const float trained[3] = {0.65f, 0.35f, 0.35f};  // of the ball's point that faces the camera
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(before.at(24, 18, c), trained[c], 0.02);
      EXPECT_NEAR(twice.at(24, 18, c), 2 * before.at(24, 18, c), 0.02 * before.at(24, 18, c));
    }
    // Beside the inner ball, what lies beyond the glass.
    EXPECT_NEAR(before.at(24, 2, 0), 1, 0.02);
    EXPECT_NEAR(twice.at(24, 2, 0), 2, 0.04);
  }
}

TEST(GlassContent, SolidThingsKeepTheLightOut) {
  RelitScene scene = test::ball_in_glass(Glass::Thin);
  std::ranges::fill(scene.materials.transmission, 0.f);
  RelitPainter painter(std::move(scene));
  painter.set_lighting(test::constant_light(1));
  EXPECT_NEAR(painter.picture(test::view_from({1, 0, 0}), {.samples = 16}).radiance.at(24, 18, 0), 0.1, 0.01);
  EXPECT_EQ(painter.lit().surface().visibility({0, 0, 0}, {1, 0, 0}), 0);
}

}  // namespace
}  // namespace vitrine
