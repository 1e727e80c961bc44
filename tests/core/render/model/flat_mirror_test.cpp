// A flat mirror: the picture that a camera behind it takes, and how what it shows learns through it.
#include <gtest/gtest.h>

#include "core/render/model/layered_model.h"
#include "tests/core/render/model/showcase.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

using test::kHalf;
using test::kSheetTolerance;
using test::Showcase;

// The side of the showcase that faces the camera is a flat mirror, with surfels `before` it that show it.
void hang_mirror(Showcase& s, double before = 0) {
  const Plane plane{{0, -kHalf, 0}, {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {kHalf, kHalf}};
  s.set->entries = {{plane, ShapeRole::Mirror, kSheetTolerance, -1, {}}};
  for (double x = -0.45; x < 0.5; x += 0.1)
    for (double z = -0.45; z < 0.5; z += 0.1) {
      const size_t i = add_surfel(s.scene.diffuse, {{x, -kHalf - before, z}, {0, -1, 0}, 0.08, 0.97, {0, 0, 0}}, 1);
      *s.scene.diffuse.at(Attribute::SpecularWeight, i) = logit(0.9f);
      *s.scene.diffuse.at(Attribute::Transmission, i) = logit(1e-4f);
    }
}

// The two pictures of one view show the same in the mirror, wherever both show something.
void expect_same_near_colors(const Frame& a, const Frame& b) {
  size_t both = 0;
  const size_t pixels = a.pixel_count();
  for (size_t i = 0; i < pixels; ++i) {
    if (a.panes.shown[i] == 0 || b.panes.shown[i] == 0) continue;
    for (size_t c = 0; c < 3; ++c) EXPECT_EQ(a.panes.near_color[c * pixels + i], b.panes.near_color[c * pixels + i]);
    ++both;
  }
  EXPECT_GT(both, 100u);
}

// A flat mirror shows what a sheet at its place mirrors, and nothing stands behind it.
TEST(FlatMirror, ShowsTheScene) {
  Showcase s;
  const Plane plane{{0, -kHalf, 0}, {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}, {kHalf, kHalf}};
  s.set->entries = {{plane, ShapeRole::Sheet, kSheetTolerance, -1, {}}};
  Frame sheet, mirror;
  LayeredModel(s.options()).forward(s.scene, s.view, sheet);
  hang_mirror(s);
  LayeredModel(s.options()).forward(s.scene, s.view, mirror);
  ASSERT_FALSE(mirror.panes.empty());
  size_t both = 0;
  const size_t pixels = mirror.pixel_count();
  for (size_t i = 0; i < pixels; ++i) {
    if (sheet.panes.shown[i] == 0 || mirror.panes.shown[i] == 0) continue;
    for (size_t c = 0; c < 3; ++c)
      EXPECT_NEAR(mirror.panes.near_color[c * pixels + i], sheet.panes.near_color[c * pixels + i], 2e-3);
    EXPECT_EQ(mirror.panes.far_share[i], 0);
    ++both;
  }
  EXPECT_GT(both, 100u);
}

// Also in a picture in which no silhouette is to be drawn.
TEST(FlatMirror, ShowsTheSceneWithoutSilhouettes) {
  Showcase s;
  hang_mirror(s);
  ImageOptions options = s.options();
  Frame with, without, close;
  LayeredModel(options).forward(s.scene, s.view, with);
  ASSERT_FALSE(with.silhouette.pixels.empty());
  options.shape.silhouettes = false;
  LayeredModel(options).forward(s.scene, s.view, without);
  EXPECT_TRUE(without.silhouette.pixels.empty());
  ASSERT_FALSE(without.panes.empty());
  expect_same_near_colors(with, without);

  // The middle of the mirror fills the picture.
  View view = s.view;
  view.intrinsics.fx *= 8, view.intrinsics.fy *= 8;
  LayeredModel(s.options()).forward(s.scene, view, close);
  EXPECT_TRUE(close.silhouette.pixels.empty());
  ASSERT_FALSE(close.panes.empty());
  EXPECT_GT(std::ranges::count(close.panes.passes_gradient, 1), int(with.pixel_count()) / 2);
}

// Training moves the surfels of a mirror a little before it: they do not hide the scene from the camera behind it.
TEST(FlatMirror, IsNotHiddenByItsOwnSurfels) {
  Showcase on, before;
  hang_mirror(on);
  hang_mirror(before, 0.6 * kSheetTolerance);
  Frame a, b;
  LayeredModel(on.options()).forward(on.scene, on.view, a);
  LayeredModel(before.options()).forward(before.scene, before.view, b);
  ASSERT_FALSE(a.panes.empty());
  ASSERT_FALSE(b.panes.empty());
  expect_same_near_colors(a, b);
}

// A flat mirror is one more camera: what it shows learns through it, colour and place.
TEST(FlatMirror, GradientsMatchFiniteDifferences) {
  Showcase s;
  hang_mirror(s);
  ImageOptions options = s.options();
  options.surface.ray_budget = 0;
  LayeredModel model(options);
  Frame frame;
  const auto loss = [&] {
    model.forward(s.scene, s.view, frame);
    double sum = 0;
    const size_t pixels = frame.pixel_count();
    for (size_t i = 0; i < pixels; ++i)  // of the mirror alone: what else shows the surfels learns as ever
      for (size_t c = 0; c < 3 && !frame.panes.empty() && frame.panes.passes_gradient[i]; ++c)
        sum += 0.5 * std::pow(double(frame.srgb[c * pixels + i]) - 0.3, 2);
    return sum;
  };
  loss();
  ASSERT_FALSE(frame.panes.grad_near.empty());
  const size_t pixels = frame.pixel_count();
  frame.grad_srgb.assign(frame.srgb.size(), 0.f);
  for (size_t i = 0; i < pixels; ++i)
    for (size_t c = 0; c < 3 && frame.panes.passes_gradient[i]; ++c)
      frame.grad_srgb[c * pixels + i] = frame.srgb[c * pixels + i] - 0.3f;
  SplatScene grad = s.scene.zeros_like();
  model.backward(s.scene, frame, grad);
  double moved = 0;
  for (const Attribute a : {Attribute::ShDc, Attribute::Opacity, Attribute::Mean}) {
    // Walls, which no pixel of the mirror shows but in the mirror.
    const size_t width = s.scene.diffuse.width(a), walls = 5;
    const auto of_walls = [&](auto values) { return values.subspan(s.panes * width, walls * width); };
    const std::vector<double> differences = extrapolated_differences(of_walls(s.scene.diffuse.values(a)), loss);
    const auto actual = of_walls(grad.diffuse.values(a));
    for (const double d : differences) moved += std::abs(d);
    expect_grad_close(std::vector<float>(actual.begin(), actual.end()), differences,
                      {.relative_l2 = 3e-2, .bias = 3e-2, .row_floor = 0.05}, std::string(row(a).name));
  }
  EXPECT_GT(moved, 1e-3);
}

}  // namespace
}  // namespace vitrine
