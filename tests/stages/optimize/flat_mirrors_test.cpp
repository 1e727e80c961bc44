// A room with a mirror on its wall, whose world behind it training has built of surfels.
#include "stages/optimize/flat_mirrors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/scene/surfels/activation.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

// The tiny scene and a wall beside it, before a mirror at y = 0.7 that faces it.
class MirrorOnAWall : public ::testing::Test {
 protected:
  MirrorOnAWall() : folder_("flat-mirrors-test") {
    testing::write_tiny_sfm(folder_.path() / "sfm", 18, 48, 36);
    capture_ = load_capture(folder_.path() / "sfm", config_.max_side, config_.holdout_every);
    for (double x = -0.8; x < 0.81; x += 0.1)
      for (double z = -0.3; z < 0.5; z += 0.1) testing::add_surfel(scene_, {-0.85, x, z}, {1, 0, 0}, 0.06, {0.3f, 0.5f, 0.2f});
    real_ = scene_.size();
    for (size_t i = 0; i < real_; ++i) {
      const float* m = scene_.at(Attribute::Mean, i);
      if (m[1] > 0.65f) continue;
      const size_t k = scene_.size();
      scene_.resize(k + 1);
      for (const Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc})
        std::copy_n(scene_.at(a, i), scene_.width(a), scene_.at(a, k));
      scene_.at(Attribute::Mean, k)[1] = float(2 * kWall) - m[1];
      *scene_.at(Attribute::Transmission, k) = logit(kDull);
    }
    for (size_t i = 0; i < scene_.size(); ++i) *scene_.at(Attribute::Transmission, i) = logit(kDull);
    gloss_.weight.assign(scene_.size(), 1.f);
    gloss_.inside.assign(scene_.size(), 0.f);
    for (size_t i = real_; i < scene_.size(); ++i) gloss_.inside[i] = 1.f;
  }
  // Off by `turn` radians and `shift`.
  ShapeSet shapes(double turn, double shift) const {
    const Vec3d n = normalized(Vec3d{std::sin(turn), -std::cos(turn), 0.5 * turn}), side = normalized(cross(Vec3d{0, 0, 1}, n));
    Plane plane{{0, kWall + shift, 0.1}, {}, {2.5, 2.5}};
    plane.axes.column(0) = side, plane.axes.column(1) = cross(n, side), plane.axes.column(2) = n;
    return {.entries = {{plane, ShapeRole::Mirror, 0.02, -1, {}}}};
  }
  LayerInitDesc desc(const ShapeSet& shapes) const {
    return {.config = config_, .capture = capture_, .targets = targets_, .shapes = shapes, .glass = shapes, .sh_degree = 0};
  }

  static constexpr double kWall = 0.7;
  TemporaryFolder folder_;
  OptimizeConfig config_ = testing::tiny_config(100);
  Capture capture_;
  Targets targets_;
  SplatLayer scene_ = testing::tiny_scene();
  size_t real_ = 0;
  MaskEvidence gloss_;
};

TEST_F(MirrorOnAWall, StandsWhereTheWorldBehindItSays) {
  const ShapeSet off = shapes(0.06, 0.01);
  const LayerInitDesc from = desc(off);
  const ShapeSet found = FlatMirrors(from, gloss_, scene_).registered();
  const Plane& plane = std::get<Plane>(found.entries[0].shape);
  EXPECT_LT(std::acos(dot(plane.axes.c2, Vec3d{0, -1, 0})) * 57.3, 0.5) << "it was 3.8 degrees off";
  EXPECT_NEAR(dot(plane.axes.c2, plane.centre), -kWall, 0.01);
  EXPECT_NEAR(dot(plane.axes.c0, plane.axes.c1), 0, 1e-12);
}

TEST_F(MirrorOnAWall, GivesBackWhatItShows) {
  const ShapeSet exact = shapes(0, 0);
  const LayerInitDesc from = desc(exact);
  SplatLayer moved = scene_;
  const std::vector<uint8_t> which = FlatMirrors(from, gloss_, scene_).reflect_into_scene(exact, moved);
  size_t count = 0;
  for (size_t i = 0; i < scene_.size(); ++i) {
    const float *was = scene_.at(Attribute::Mean, i), *is = moved.at(Attribute::Mean, i);
    count += which[i];
    ASSERT_EQ(which[i] != 0, i >= real_ && which[i] != 0) << "what stands before it stays";
    EXPECT_NEAR(is[1], which[i] ? float(2 * kWall) - was[1] : was[1], 1e-5);
    EXPECT_NEAR(is[0], was[0], 1e-5);
  }
  EXPECT_GT(count, (scene_.size() - real_) / 2);
}

// Where nothing before the mirror is like what stands behind it the plane stays, and so it does without the option.
TEST_F(MirrorOnAWall, StaysWhereNothingAgrees) {
  for (size_t i = real_; i < scene_.size(); ++i)
    for (size_t c = 0; c < 3; ++c) scene_.at(Attribute::ShDc, i)[c] = 3;
  const ShapeSet off = shapes(0.06, 0.01);
  const LayerInitDesc from = desc(off);
  const Plane start = std::get<Plane>(off.entries[0].shape),
              plane = std::get<Plane>(FlatMirrors(from, gloss_, scene_).registered().entries[0].shape);
  EXPECT_EQ(plane.centre, start.centre);
  EXPECT_EQ(plane.axes.c2, start.axes.c2);
  config_.shading.shapes = false;
  EXPECT_TRUE(FlatMirrors(from, gloss_, scene_).empty());
}

}  // namespace
}  // namespace vitrine
