// Poses that training corrects: nearer to the truth than the given ones, written for later stages, the same after an
// interruption.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/json.h"
#include "core/learn/trainer/pose_training.h"
#include "core/scene/camera/corrected_poses.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

using testing::TestContext;

constexpr double kOff_rad = 8e-3;
constexpr size_t kWrong[] = {0, 6, 9};  // held out, held out, trains

class TinyPoses : public ::testing::Test {
 protected:
  // Photos of which the two that are held out and one that trains are given with poses that are off by 0.46 degrees, and by as
  // much of the scene radius: 0.9 pixels.
  void SetUp() override {
    truth_ = testing::ring_of_views(12, 96, 72);
    testing::write_sfm_of(sfm(), truth_, {.diffuse = testing::tiny_scene()});
    ColmapModel model = read_colmap_model(sfm() / "sparse/0");
    for (const size_t i : kWrong) {
      const Rigid pose = moved_pose(model.images[i].cam_from_world(), {kOff_rad, 0, 0}, {kOff_rad, 0, 0});
      model.images[i].rotation = quaternion(pose.rotation);
      model.images[i].translation = pose.translation;
    }
    write_colmap_model(sfm() / "sparse/0", model, ColmapFormat::Binary);
  }
  fs::path sfm() const { return folder_.path() / "sfm"; }
  fs::path work(const char* name) const { return folder_.path() / name; }
  static OptimizeConfig config(WantedPoses poses, int steps) {
    OptimizeConfig c = testing::tiny_config(steps);
    c.initial.stereo_side = 48;
    c.poses = poses;
    return c;
  }
  // Root of the mean square distance of points of the scene to their true places in the picture, pixels.
  double error(const std::vector<View>& views, size_t photo) const {
    const auto at = [&](const View& view, const Vec3d& point) {
      const Vec3d p = view.cam_from_world * point;
      return Vec2d{view.intrinsics.fx * p.x / p.z, view.intrinsics.fy * p.y / p.z};
    };
    double sum = 0, count = 0;
    for (double x = -0.3; x < 0.4; x += 0.3)
      for (double y = -0.3; y < 0.4; y += 0.3) {
        const Vec2d off = at(views[photo], {x, y, -0.3}) - at(truth_[photo], {x, y, -0.3});
        sum += off.x * off.x + off.y * off.y, ++count;
      }
    return std::sqrt(sum / count);
  }
  std::vector<View> truth_;
  TemporaryFolder folder_;
};

TEST_F(TinyPoses, ComeNearerToTheTruthAndPicturesGain) {
  TestContext given(sfm(), work("given")), corrected(sfm(), work("corrected"));
  run_optimize(config(WantedPoses::Given, 160), given);
  run_optimize(config(WantedPoses::Auto, 160), corrected);
  EXPECT_FALSE(has_corrected_poses(given.output()));
  ASSERT_TRUE(has_corrected_poses(corrected.output()));
  const std::vector<View> before = load_view_set(sfm(), given.output()).views;
  const std::vector<View> after = load_view_set(sfm(), corrected.output()).views;
  for (const size_t photo : kWrong) {
    EXPECT_LT(error(after, photo), 0.75 * error(before, photo)) << photo;
  }
  EXPECT_GT(corrected.metrics.at("heldout_psnr"), given.metrics.at("heldout_psnr") + 0.5);
  const auto report = nlohmann::json::parse(read_file(corrected.output() / "optimize/report.json")).at("poses");
  EXPECT_TRUE(report.at("corrected"));
  EXPECT_GT(report.at("train").at("turn_deg").get<double>(), 0.05);
  EXPECT_GE(report.at("heldout").at("largest_shift").get<double>(), report.at("heldout").at("shift").get<double>());
}

TEST_F(TinyPoses, AKilledRunEndsWithTheSameBytes) {
  TestContext whole(sfm(), work("whole"));
  run_optimize(config(WantedPoses::Auto, 60), whole);
  OptimizeConfig often = config(WantedPoses::Auto, 60);
  often.checkpoint_every = 10;
  TestContext stopped(sfm(), work("stopped"));
  stopped.after_step = [](int step) {
    if (step == 43) throw testing::Stopped();
  };
  EXPECT_THROW(run_optimize(often, stopped), testing::Stopped);
  TestContext resumed(sfm(), work("stopped"));
  run_optimize(often, resumed);
  for (const char* file : {"gaussians/diffuse.ply", "optimize/poses.json", "optimize/report.json"})
    EXPECT_EQ(read_file(whole.output() / file), read_file(resumed.output() / file)) << file;
}

TEST_F(TinyPoses, StayAsGivenWhereLayersAreTrained) {
  OptimizeConfig layered = config(WantedPoses::Auto, 12);
  layered.layers = WantedLayers::Reflection;
  TestContext context(sfm(), work("layered"));
  run_optimize(layered, context);
  EXPECT_EQ(context.warnings, std::vector<std::string>{"POSES_GIVEN"});
  EXPECT_FALSE(has_corrected_poses(context.output()));
}

}  // namespace
}  // namespace vitrine
