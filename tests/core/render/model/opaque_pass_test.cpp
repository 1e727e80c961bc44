// Pictures of a scene and of its opaque twin, blended.
#include "core/render/model/opaque_pass.h"

#include <gtest/gtest.h>

#include "tests/core/render/model/ball_before_wall.h"

namespace vitrine {
namespace {

constexpr float kElsewhere = 0.75f;

// Every surfel of the ball and the wall once more, of another colour and without gloss.
SplatLayer twin_of(const SplatLayer& diffuse) {
  SplatLayer twin = diffuse;
  for (size_t i = 0; i < twin.size(); ++i) twin.at(Attribute::ShDc, i)[0] += 1, twin.at(Attribute::ShDc, i)[2] -= 0.2f;
  return twin;
}

std::vector<float> picture(const BallBeforeWall& b, double of_ball, bool differentiable, Frame& frame) {
  auto set = std::make_shared<ShapeSet>(*b.set);
  set->entries[0].layered = of_ball;
  ImageOptions options = b.options;
  options.shape.set = set;
  options.opaque.layered = kElsewhere;
  options.composite.layer_images = true;
  frame.differentiable = differentiable;
  LayeredModel(options).forward(b.room.scene, b.room.view, frame);
  return frame.linear;
}

TEST(OpaquePass, PicturesAreMeansOfBothInLinearLightByWhatAPixelShows) {
  BallBeforeWall b;
  Frame frame, of_twin;
  const std::vector<float> layers = picture(b, 0.25, false, frame);
  b.room.scene.opaque = twin_of(b.room.scene.diffuse);
  ImageOptions plain = b.options;
  plain.shape.set = nullptr;
  LayeredModel(plain).forward({.diffuse = b.room.scene.opaque}, b.room.view, of_twin);

  const std::vector<float> blended = picture(b, 0.25, false, frame);
  const std::vector<uint32_t> shown = shapes_shown(frame);
  size_t ball = 0, reflected = 0;
  for (size_t i = 0; i < blended.size(); ++i) {
    const bool on_ball = shown[i % shown.size()] != 0;  // its whole silhouette: below
    const float s = on_ball ? 0.25f : kElsewhere;
    ball += on_ball;
    EXPECT_NEAR(blended[i], s * layers[i] + (1 - s) * of_twin.linear[i], 1e-5f);
    EXPECT_NEAR(frame.layers.diffuse[i] + frame.layers.reflection[i], blended[i], 1e-5f) << "its parts add up";
    reflected += frame.layers.reflection[i] > 0;
  }
  for (const SilhouettePixel& p : frame.silhouette.pixels) EXPECT_EQ(shown[p.pixel] != 0, p.covered > 0);
  EXPECT_GT(ball, 500u);
  EXPECT_LT(ball, blended.size() - 500);
  EXPECT_GT(reflected, 300u);
}

TEST(OpaquePass, TrainingAndScenesWithoutATwinSeeTheLayersAlone) {
  BallBeforeWall b;
  Frame frame;
  const std::vector<float> layers = picture(b, 0.25, true, frame);
  EXPECT_EQ(picture(b, 1, false, frame), layers);
  b.room.scene.opaque = twin_of(b.room.scene.diffuse);
  EXPECT_EQ(picture(b, 0.25, true, frame), layers);
}

TEST(OpaquePass, APixelBelongsToGlassBeforeMirrorsBeforeCoats) {
  View view;
  view.intrinsics = {5, 1, 1, 1, 0, 0};
  Frame frame;
  frame.view = &view;
  EXPECT_EQ(shapes_shown(frame), std::vector<uint32_t>(5, 0));
  frame.coats.entry = {1, 1, 1, 1, 0};
  frame.silhouette.shapes = {0, 2, 2, 0, 0};
  frame.silhouette.pixels = {{.pixel = 3, .entry = 2, .covered = 0.5f}, {.pixel = 4, .entry = 2, .covered = 0}};
  frame.sheets.entry = {0, 0, 4, 0, 0};
  EXPECT_EQ(shapes_shown(frame), (std::vector<uint32_t>{1, 2, 4, 3, 0}));
}

}  // namespace
}  // namespace vitrine
