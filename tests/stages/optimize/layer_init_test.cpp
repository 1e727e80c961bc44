// Materials that layers begin with: masks of one class say nothing about the surfaces of another.
#include <gtest/gtest.h>

#include "core/scene/surfels/activation.h"
#include "core/observe/stereo/box_fit.h"
#include "stages/optimize/layer_init.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

// The tiny scene with masks of a box of glass around its ball, and no mask of another class.
class GlassAlone : public ::testing::Test {
 protected:
  GlassAlone() : folder_("layer-init-test") {
    const fs::path sfm = folder_.path() / "sfm", masks = folder_.path() / "glass";
    testing::write_tiny_sfm(sfm, 18, 48, 36);
    const Box box{Mat3d::identity(), {-0.3, -0.3, -0.29}, {0.3, 0.3, 0.3}};
    for (const View& view : testing::ring_of_views(18, 48, 36)) {
      const std::vector<uint8_t> inside = silhouette_mask(box, view);
      Image8 mask(48, 36, 1);
      for (size_t i = 0; i < inside.size(); ++i) mask.data()[i] = inside[i] ? 255 : 0;
      write_ldr(masks / "masks/transparent" / (view.stem() + ".png"), mask);
    }
    capture_ = load_capture(sfm, config_.max_side, config_.holdout_every);
    ObjectSet set = test::one_object(box, ObjectRole::ThinGlass, 0.02, false);  // as a visual hull
    glass_ = set.shapes;
    test::write_objects_artifact(masks, masks, capture_.view_set.views, std::move(set));
    targets_ = load_targets(capture_, {}, LabelledObjects::trusted(masks), {});
    scene_.reflection = SplatLayer(LayerKind::Reflection, 0, 0);
    scene_.transmittance = SplatLayer(LayerKind::Transmittance, 0, 0);
  }
  LayerInitDesc desc() const {
    return {.config = config_, .capture = capture_, .targets = targets_, .shapes = shapes_, .glass = glass_, .sh_degree = 0};
  }
  double value(Attribute a, size_t i) const { return double(sigmoid(*scene_.diffuse.at(a, i))); }

  TemporaryFolder folder_;
  OptimizeConfig config_ = testing::tiny_config(100);
  Capture capture_;
  Targets targets_;
  ShapeSet shapes_, glass_;
  SplatScene scene_{.diffuse = testing::tiny_scene()};
};

TEST_F(GlassAlone, MakesNoMirrorOfAWall) {
  for (size_t i = 0; i < scene_.diffuse.size(); ++i)
    *scene_.diffuse.at(Attribute::SpecularWeight, i) = *scene_.diffuse.at(Attribute::Transmission, i) = logit(kDull);
  begin_transmittance(desc(), 200, 1000, scene_);
  begin_reflection(desc(), 200, 1000, scene_);
  ASSERT_GT(scene_.reflection.size(), 0u) << "glass reflects";
  for (size_t i = 0; i < scene_.diffuse.size(); ++i) ASSERT_LT(value(Attribute::SpecularWeight, i), 1 / 255.0) << i;
}

TEST_F(GlassAlone, KeepsItsReflectanceWhenReflectionBegins) {
  begin_transmittance(desc(), 200, 1000, scene_);
  begin_reflection(desc(), 200, 1000, scene_);
  size_t glass = 0;
  for (size_t i = 0; i < scene_.diffuse.size(); ++i) {
    if (!(value(Attribute::Transmission, i) > 0.5)) continue;
    ++glass;
    ASSERT_NEAR(value(Attribute::F0, i), config_.phases.transmittance.f0, 1e-4) << i;
  }
  EXPECT_GT(glass, 50u);
}

// Glass that the photos do not fix in space. What stands behind it must not leave the picture.
TEST_F(GlassAlone, IsNoHoleWhereNoGlassCanBePlaced) {
  glass_ = {};
  for (size_t i = 0; i < scene_.diffuse.size(); ++i)
    *scene_.diffuse.at(Attribute::SpecularWeight, i) = *scene_.diffuse.at(Attribute::Transmission, i) = logit(kDull);
  const SplatScene before = scene_;
  const HullCounts counts = begin_transmittance(desc(), 200, 1000, scene_);
  EXPECT_EQ(counts.hull, 0u);
  EXPECT_EQ(counts.moved, 1u) << "a layer has a surfel";
  ASSERT_EQ(scene_.diffuse.size() + 1, before.diffuse.size());
  LayeredModel model(ImageOptions{});
  Frame frame;
  const View& view = capture_.photos[0].levels[0].view;
  model.forward(before, view, frame);
  const std::vector<float> was = frame.srgb;
  model.forward(scene_, view, frame);
  size_t changed = 0;
  for (size_t i = 0; i < was.size(); ++i) changed += std::abs(was[i] - frame.srgb[i]) > 0.02f;
  EXPECT_LT(changed, was.size() / 50);
}

// The tiny scene with masks of its ball, which is painted.
class PaintedBall : public ::testing::Test {
 protected:
  PaintedBall() : folder_("painted-ball-test") {
    const fs::path sfm = folder_.path() / "sfm", masks = found();
    testing::write_tiny_sfm(sfm, 18, 48, 36);
    SurfaceOfRevolution ball{{0, 0, 0}, {0, 0, 1}, {}};
    for (int i = 0; i <= 24; ++i) {
      const double polar = std::numbers::pi * i / 24;
      ball.profile.push_back({kRadius * std::sin(polar), -kRadius * std::cos(polar)});
    }
    ball_ = ball;
    for (const View& view : testing::ring_of_views(18, 48, 36)) {
      const std::vector<uint8_t> inside = mask_of_rays(view, [&](size_t, const Vec3d& eye, const Vec3d& direction) {
        return ball.intersect({eye, direction}).has_value();
      });
      Image8 mask(48, 36, 1);
      for (size_t i = 0; i < inside.size(); ++i) mask.data()[i] = inside[i] ? 255 : 0;
      write_ldr(masks / "masks/specular" / (view.stem() + ".png"), mask);
    }
    capture_ = load_capture(sfm, config_.max_side, config_.holdout_every);
    scene_.reflection = SplatLayer(LayerKind::Reflection, 0, 0);
  }
  fs::path found() const { return folder_.path() / "found"; }
  void mark(ObjectRole role, bool exact) {
    const ObjectSet set = test::one_object(ball_, role, 0.06 * kRadius, exact);
    test::write_objects_artifact(found(), found(), capture_.view_set.views, set);
    const auto objects = LabelledObjects::trusted(found());
    targets_ = load_targets(capture_, {}, objects, {});
    shapes_ = objects.objects().drawn_shapes();
  }
  HullCounts begin() {
    const ShapeSet no_glass;
    return begin_reflection(
        {.config = config_, .capture = capture_, .targets = targets_, .shapes = shapes_, .glass = no_glass, .sh_degree = 0}, 200,
        1000, scene_);
  }
  double value(Attribute a, size_t i) const { return double(sigmoid(*scene_.diffuse.at(a, i))); }
  bool on_ball(size_t i) const {
    const float* m = scene_.diffuse.at(Attribute::Mean, i);
    return std::abs(length(Vec3d{m[0], m[1], m[2]}) - kRadius) < 0.01;
  }

  static constexpr double kRadius = 0.25;
  TemporaryFolder folder_;
  OptimizeConfig config_ = testing::tiny_config(100);
  Capture capture_;
  Targets targets_;
  ShapeSet shapes_;
  SurfaceOfRevolution ball_;
  SplatScene scene_{.diffuse = testing::tiny_scene()};
};

TEST_F(PaintedBall, KeepsItsSurfelsUnderACoat) {
  for (const bool exact : {true, false}) {
    mark(ObjectRole::Coat, exact);
    scene_.diffuse = testing::tiny_scene();
    const SplatLayer before = scene_.diffuse;
    const HullCounts counts = begin();
    EXPECT_EQ(counts.moved, 0u);
    EXPECT_EQ(counts.hull, 0u);
    EXPECT_TRUE(counts.known_points.empty()) << "nothing is held";
    ASSERT_EQ(scene_.diffuse.size(), before.size());
    for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
      EXPECT_TRUE(std::ranges::equal(scene_.diffuse.values(a), before.values(a)));
    double k_s = 0, f0 = 0, count = 0;
    for (size_t i = 0; i < scene_.diffuse.size(); ++i) {
      EXPECT_LT(value(Attribute::SpecularWeight, i), config_.phases.reflection.coat_specular_weight + 1e-3);
      const float* m = scene_.diffuse.at(Attribute::Mean, i);
      if (!on_ball(i) || m[2] < 0) continue;
      k_s += value(Attribute::SpecularWeight, i), f0 += value(Attribute::F0, i), ++count;
    }
    ASSERT_GT(count, 20);
    EXPECT_NEAR(k_s / count, config_.phases.reflection.coat_specular_weight, 0.008);
    EXPECT_NEAR(f0 / count, config_.phases.reflection.coat_f0, 1e-3);
    ASSERT_TRUE(counts.shapes.has(ShapeRole::Coat)) << "pictures show it";
    EXPECT_EQ(counts.shapes.entries[0].exact, exact);
  }
}

TEST_F(PaintedBall, LosesItsSurfelsWhereItMirrors) {
  mark(ObjectRole::Mirror, true);
  const size_t before = scene_.diffuse.size();
  const HullCounts counts = begin();
  EXPECT_GT(counts.moved, 5u);
  EXPECT_EQ(scene_.diffuse.size(), before - counts.moved + counts.hull);
}

// A mirror of which only a visual hull is known keeps its surfels, too.
TEST_F(PaintedBall, IsAMirrorInTheMasksIfItsShapeIsKnown) {
  const auto pixels = [&](ObjectRole role, bool exact) {
    mark(role, exact);
    size_t coat = 0, specular = 0;
    for (const auto& levels : targets_.photos)
      for (const TargetLevel& level : levels) {
        coat += size_t(std::ranges::count_if(level.coat, [](uint8_t v) { return v > 0; }));
        specular += size_t(std::ranges::count_if(level.masks[size_t(MaskClass::Specular)], [](uint8_t v) { return v > 0; }));
      }
    EXPECT_TRUE(targets_.any(MaskClass::Specular)) << "it reflects";
    return std::pair(coat, specular);
  };
  const size_t all = pixels(ObjectRole::Coat, true).first;
  EXPECT_GT(all, 500u);
  EXPECT_EQ(pixels(ObjectRole::Coat, true), std::pair(all, size_t{0}));
  EXPECT_EQ(pixels(ObjectRole::Mirror, false), std::pair(all, size_t{0}));
  EXPECT_EQ(pixels(ObjectRole::Mirror, true), std::pair(size_t{0}, all));
}

}  // namespace
}  // namespace vitrine
