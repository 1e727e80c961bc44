// Objects whose surroundings do not stand still with them.
#include "stages/optimize/surroundings.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/optimize.h"
#include "tests/core/observe/stereo/silhouettes_of_rays.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

// A ball of radius 0.25 seen by 12 cameras, whose masks are right.
struct Ball {
  Ball() {
    for (const Silhouette& m : silhouettes_of_rays(12, 2 * std::numbers::pi,
                                                   [](const Vec3d&eye, const Vec3d&d) { return meets_ball({}, 0.25, eye, d); })) {
      capture.train.push_back(uint32_t(capture.photos.size()));
      capture.photos.emplace_back().levels[0].view = m.view;
      auto& object = targets.photos.emplace_back()[0].masks[size_t(MaskClass::Object)];
      for (float inside : m.value.data()) object.push_back(inside > 0 ? 255 : 0);
    }
    targets.has[size_t(MaskClass::Object)] = true;
  }
  void point(const Vec3d& position) {
    ScenePoint p;
    p.position = position;
    p.views = capture.train;
    capture.view_set.points.push_back(p);
  }
  Capture capture;
  Targets targets;
};

TEST(ObjectAlone, SightingsOfSparsePointsLieOutsideItsMasks) {
  Ball ball;
  for (int i = 0; i < 19; ++i) ball.point({0.01 * i, 0, 0});
  EXPECT_EQ(sightings_outside_object(ball.capture, ball.targets), 0);
  ball.point({0.4, 0.4, 0});
  EXPECT_GT(sightings_outside_object(ball.capture, ball.targets), 0);
  ball.targets.forget(MaskClass::Object);
  EXPECT_EQ(sightings_outside_object(ball.capture, ball.targets), 1);
}

TEST(ObjectAlone, IsAskedOfNoPhotoWhereTheUserSaysIt) {
  Ball ball;
  const auto no_depth = []() -> const DenseDepth& { throw std::logic_error("no depth is needed"); };
  EXPECT_EQ(surroundings_to_train(WantedSurroundings::Train, {}, ball.capture, no_depth, ball.targets).trained,
            Trained::Everything);
  EXPECT_EQ(surroundings_to_train(WantedSurroundings::Ignore, {}, ball.capture, no_depth, ball.targets).trained,
            Trained::ObjectAlone);
  ball.targets.forget(MaskClass::Object);
  EXPECT_EQ(surroundings_to_train(WantedSurroundings::Ignore, {}, ball.capture, no_depth, ball.targets).trained,
            Trained::Everything);
}

TEST(ObjectAlone, IsTrainedWhereItWasMovedBetweenPasses) {
  Ball ball;
  Passes passes(2);
  for (size_t i = 0; i < ball.capture.photos.size(); ++i) {
    ball.capture.photos[i].levels[0].view.name = fmt::format("{}.jpg", i);
    passes[i < 7 ? 0 : 1].push_back(ball.capture.photos[i].name());
  }
  ball.capture.heldout = {0, 11};
  const auto no_depth = []() -> const DenseDepth& { throw std::logic_error("no depth is needed"); };
  const Surroundings surroundings = surroundings_to_train(WantedSurroundings::Auto, passes, ball.capture, no_depth, ball.targets);
  EXPECT_EQ(surroundings.trained, Trained::ObjectAlone);
  EXPECT_NE(surroundings.why.find("2 passes: 7 and 5 photos"), std::string::npos) << surroundings.why;
  // With its surroundings it is trained from the photos of one pass.
  keep_largest_pass(passes, ball.capture);
  EXPECT_EQ(ball.capture.train, (std::vector<uint32_t>{0, 1, 2, 3, 4, 5, 6}));
  EXPECT_EQ(ball.capture.heldout, (std::vector<uint32_t>{0}));
  keep_largest_pass({}, ball.capture);
  EXPECT_EQ(ball.capture.train.size(), 7u);
}

TEST(ObjectAlone, StandsWhereItsMasksAllow) {
  const Ball ball;
  EXPECT_TRUE(on_object(ball.capture, ball.targets, {0.1, 0.1, 0}));
  EXPECT_FALSE(on_object(ball.capture, ball.targets, {0.35, 0, 0}));
  EXPECT_TRUE(on_object(ball.capture, ball.targets, {0, 0, 90}));  // no photo shows it
}

TEST(ObjectAlone, IsAllThatARunTrains) {
  const TemporaryFolder folder("object-alone");
  const fs::path sfm = folder.path() / "sfm", masks = folder.path() / "masks-of-object";
  testing::write_tiny_sfm(sfm, 12, 48, 36, testing::tiny_mirror_scene());
  fs::create_directories(masks / "masks");
  fs::copy(sfm / "masks/specular", masks / "masks/object", fs::copy_options::recursive);
  OptimizeConfig config = testing::tiny_config(60);
  config.max_gaussians = 1000;
  config.initial.frustum_points = 800;
  for (const WantedSurroundings surroundings : {WantedSurroundings::Train, WantedSurroundings::Ignore}) {
    const bool ignored = surroundings == WantedSurroundings::Ignore;
    config.surroundings = surroundings;
    testing::TestContext context(sfm, folder.path() / (ignored ? "ignore" : "train"));
    context.masks = masks;
    run_optimize(config, context);
    const auto views = nlohmann::json::parse(read_file(context.output() / "optimize/views.json"));
    EXPECT_EQ(views.value("object_alone", false), ignored);
    const Capture capture = load_capture(sfm, 48, 6);
    const Targets targets = load_targets(capture, masks, {}, std::nullopt);
    const SplatLayer layer = read_layer(context.output() / "gaussians/diffuse.ply");
    size_t on = 0;
    for (size_t i = 0; i < layer.size(); ++i) {
      const float* m = layer.at(Attribute::Mean, i);
      on += on_object(capture, targets, {m[0], m[1], m[2]});
    }
    ASSERT_GT(layer.size(), 20u);
    if (ignored)
      EXPECT_GT(double(on), 0.7 * double(layer.size()));  // measured 0.79: rims, with masks of 48x36 pixels
    else
      EXPECT_LT(double(on), 0.6 * double(layer.size()));
  }
}

}  // namespace
}  // namespace vitrine
