// Materials that layers begin with: masks of one class say nothing about the surfaces of another.
#include <gtest/gtest.h>

#include "core/scene/activation.h"
#include "core/stereo/box_fit.h"
#include "stages/optimize/layer_init.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

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
    capture_ = load_capture(sfm, config_.resolution.max_side, config_.holdout_every);
    targets_ = load_targets(capture_, masks, {});
    scene_.reflection = SplatLayer(LayerKind::Reflection, 0, 0);
    scene_.transmittance = SplatLayer(LayerKind::Transmittance, 0, 0);
  }
  LayerInitDesc desc() const {
    return {.config = config_, .capture = capture_, .targets = targets_, .shapes = shapes_, .sh_degree = 0};
  }
  double value(Attribute a, size_t i) const { return double(sigmoid(*scene_.diffuse.at(a, i))); }

  TemporaryFolder folder_;
  OptimizeConfig config_ = testing::tiny_config(100);
  Capture capture_;
  Targets targets_;
  ShapeSet shapes_;
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

}  // namespace
}  // namespace vitrine
