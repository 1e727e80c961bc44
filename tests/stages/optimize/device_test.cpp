// --device of the training, from the command line to the bytes and the key, with the kernels as loops where the card would be.
#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/learn/trainer/blocks/step_blocks.h"
#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/device.h"
#include "core/render/trace/blocks/trace_pass.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/optimize.h"
#include "tests/stages/optimize/tiny_capture.h"

namespace vitrine {
namespace {

using nlohmann::json;

class TrainingOnADevice : public ::testing::Test {
 protected:
  TrainingOnADevice() { testing::write_tiny_sfm(folder_.path() / "sfm", 8); }
  ~TrainingOnADevice() override {
    provide_device(before_);
    provide_step_device(steps_before_);
    provide_device_tracer(tracers_before_);
    use_device(Device::Cpu);
  }
  static void give_kernels() {
    provide_device([]() -> std::unique_ptr<blocks::BlockPass> {
      return std::make_unique<blocks::ExecutorPass<blocks::BlockLoops>>(blocks::BlockLoops());
    });
    provide_step_device([]() -> std::unique_ptr<blocks::StepPass> {
      return std::make_unique<blocks::StepBlocks<blocks::BlockLoops>>(blocks::BlockLoops());
    });
    provide_device_tracer([]() -> std::unique_ptr<blocks::TracePass> {
      ++tracers;
      return std::make_unique<blocks::ExecutorTrace<blocks::BlockLoops>>(blocks::BlockLoops());
    });
  }
  // Exit code of vitrine-optimize; its results are in `name`.
  int train(const std::string& name, const std::string& device, std::vector<std::string> more = {}) {
    std::vector<std::string> words{
        "vitrine-optimize", "-q", "-i", "sfm=" + (folder_.path() / "sfm").string(), "-o", (folder_.path() / name).string()};
    for (const char* set :
         {"iterations=12", "max_gaussians=500", "initial.frustum_points=200", "initial.stereo_side=32", "fill_unseen=false"})
      more.insert(more.begin(), {"--set", set});
    if (!device.empty()) more.insert(more.begin(), {"--device", device});
    words.insert(words.end(), more.begin(), more.end());
    std::vector<char*> arguments;
    for (std::string& w : words) arguments.push_back(w.data());
    return stage_main(optimize_stage(), int(arguments.size()), arguments.data());
  }
  json key(const std::string& device) {
    ::testing::internal::CaptureStdout();
    EXPECT_EQ(train("keys", device, {"--print-key"}), 0);
    return json::parse(::testing::internal::GetCapturedStdout());
  }
  SplatLayer surfels(const std::string& name, LayerKind kind = LayerKind::Diffuse) {
    return read_layer(folder_.path() / name / "gaussians" / fmt::format("{}.ply", vitrine::name(kind)));
  }

  DevicePassMaker before_ = provide_device(nullptr);
  StepPassMaker steps_before_ = provide_step_device(nullptr);
  DeviceTraceMaker tracers_before_ = provide_device_tracer(nullptr);
  static inline int tracers = 0;  // made on the device
  TemporaryFolder folder_;
};

TEST_F(TrainingOnADevice, GivesTheSceneOfTheCpuUnderItsOwnKey) {
  give_kernels();
  const json of_device = key("cuda");
  EXPECT_EQ(of_device.at("terms").at("tool.renderer"), "cuda-2");
  EXPECT_EQ(key("auto"), of_device);
  EXPECT_EQ(key("cpu"), key(""));
  EXPECT_NE(key("cpu").at("key"), of_device.at("key"));
  EXPECT_EQ(of_device.at("terms").size(), key("cpu").at("terms").size()) << "the option itself is in no key";

  ASSERT_EQ(train("device", "cuda"), 0);
  ASSERT_EQ(train("again", "cuda"), 0);
  ASSERT_EQ(train("cpu", "cpu"), 0);
  const SplatLayer device = surfels("device"), again = surfels("again"), cpu = surfels("cpu");
  ASSERT_EQ(device.size(), cpu.size());
  double worst = 0;
  size_t other = 0;
  for (const AttributeRow& r : kAttributes)
    for (size_t i = 0; i < device.values(r.id).size(); ++i) {
      ASSERT_EQ(device.values(r.id)[i], again.values(r.id)[i]);
      worst = std::max(worst, double(std::abs(device.values(r.id)[i] - cpu.values(r.id)[i])));
      other += device.values(r.id)[i] != cpu.values(r.id)[i];
    }
  EXPECT_GT(other, 100u) << "the device was not used";
  EXPECT_LT(worst, 0.2) << "Adam makes steps of tiny gradients, too";
}

// Layers that begin and gaps that are closed change the surfels on the host, in the middle of the run.
TEST_F(TrainingOnADevice, GoesOnWhenALayerBegins) {
  give_kernels();
  for (const char* name : {"device", "again"})
    ASSERT_EQ(train(name, "cuda", {"--set", "layers=full", "--set", "iterations=20", "--set", "fill_unseen=true"}), 0);
  EXPECT_GT(tracers, 0);
  tracers = 0;
  ASSERT_EQ(train("cpu", "cpu", {"--set", "layers=full", "--set", "iterations=20", "--set", "fill_unseen=true"}), 0);
  EXPECT_EQ(tracers, 0);
  for (LayerKind kind : kAllLayers) {
    SCOPED_TRACE(vitrine::name(kind));
    const SplatLayer device = surfels("device", kind), cpu = surfels("cpu", kind);
    EXPECT_EQ(device, surfels("again", kind));
    EXPECT_EQ(device.size(), cpu.size());
  }
}

TEST_F(TrainingOnADevice, WithoutOneIsAnErrorAndLeavesNothing) {
  EXPECT_EQ(train("none", "cuda"), 8);
  EXPECT_FALSE(fs::exists(folder_.path() / "none"));
  EXPECT_EQ(key("auto"), key("cpu"));
  EXPECT_EQ(train("none", "card"), 2);
}

}  // namespace
}  // namespace vitrine
