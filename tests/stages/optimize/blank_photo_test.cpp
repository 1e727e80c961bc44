#include <gtest/gtest.h>

#include "core/learn/trainer/capture.h"
#include "core/learn/trainer/training.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/surface_pass.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/optimize.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

using testing::TestContext;
using testing::write_tiny_sfm;

// A photo with a pose that looks away from everything: the last step may be its turn, and the scene is as good as before.
TEST(OptimizeStageAlone, APhotoThatShowsNoSurfelIsNoCollapse) {
  constexpr uint32_t kAway = 2;
  const TemporaryFolder folder;
  const fs::path sfm = folder.path() / "sfm";
  write_tiny_sfm(sfm, 5);
  ColmapModel model = read_colmap_model(sfm / "sparse/0");
  ColmapImage& image = model.images[kAway];
  const Rigid turned = Rigid{Mat3d{{-1, 0, 0}, {0, 1, 0}, {0, 0, -1}}, {}} * image.cam_from_world();
  image.rotation = quaternion(turned.rotation);
  image.translation = turned.translation;
  image.points.clear();
  for (ColmapPoint3D& point : model.points)
    std::erase_if(point.track, [&](const ColmapTrackElement& t) { return t.image_id == image.id; });
  write_colmap_model(sfm / "sparse/0", model, ColmapFormat::Binary);

  OptimizeConfig config;
  config.max_gaussians = 700;
  config.holdout_every = 0;
  config.initial.frustum_points = 0;
  config.initial.stereo_side = 24;
  config.fill_unseen = false;
  const Capture capture = load_capture(sfm, 0, 0);
  const std::vector<uint32_t> order = photo_order(capture.train, uint64_t(config.seed), 1);
  config.iterations = int(order.size() + 1 + size_t(std::ranges::find(order, kAway) - order.begin()));
  TestContext context(sfm, folder.path() / "work");
  run_optimize(config, context);
  Frame frame;
  ImageModel image_model({.diffuse = {.sh_degree = 0}});
  image_model.emplace<DiffusePass>();
  image_model.forward({.diffuse = read_layer(context.output() / "gaussians/diffuse.ply")}, capture.photos[kAway].levels[0].view,
                      frame);
  EXPECT_EQ(std::ranges::max(frame.diffuse.plane(Aov::Alpha)), 0) << "or the last step would be no test";
}

}  // namespace
}  // namespace vitrine
