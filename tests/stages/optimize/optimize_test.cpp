#include "stages/optimize/optimize.h"

#include <gtest/gtest.h>

#include <csignal>
#include <functional>
#include <limits>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/initialise.h"
#include "stages/optimize/plane_inpainting.h"
#include "stages/optimize/trainer.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"
#include "tests/support/feature_network_file.h"

namespace vitrine {
namespace {

using testing::Stopped;
using testing::TestContext;
using testing::write_tiny_sfm;

constexpr int kAllPixels = 48;  // of the tiny photos

void shorten(OptimizeConfig& config, int iterations) {
  config.iterations = iterations;
  config.max_gaussians = 700;
  config.initial.frustum_points = 300;
  config.initial.stereo_side = 24;  // most of the time under the sanitizers; tests that judge the result take all pixels
  config.densify.every = 10;
  config.preview_every = 20;
  config.checkpoint_every = 7;
}

class OptimizeStage : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder("optimize-test");
    write_tiny_sfm(sfm(), 18);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
    set_thread_limit(0);
  }
  static fs::path sfm() { return folder_->path() / "sfm"; }
  static fs::path work(const std::string& name) { return folder_->path() / name; }

 private:
  static TemporaryFolder* folder_;
};
TemporaryFolder* OptimizeStage::folder_ = nullptr;

TEST_F(OptimizeStage, LearnsTheTinySceneAndWritesItsFiles) {
  OptimizeConfig config;
  shorten(config, 300);
  config.initial.stereo_side = kAllPixels;
  config.holdout_every = 6;
  TestContext context(sfm(), work("learn"));
  run_optimize(config, context);
  TestContext untrained(sfm(), work("untrained"));
  OptimizeConfig one_step;
  shorten(one_step, 1);
  one_step.initial.stereo_side = kAllPixels;
  one_step.holdout_every = 6;
  run_optimize(one_step, untrained);
  EXPECT_GT(context.metrics.at("heldout_psnr"), 18.5);
  EXPECT_GT(context.metrics.at("heldout_psnr"), untrained.metrics.at("heldout_psnr") + 4) << untrained.metrics.at("heldout_psnr");
  EXPECT_TRUE(context.timings.contains("stereo_seconds"));
  EXPECT_EQ(context.last_progress.fraction, 1);
  EXPECT_NE(context.summary_text.find("PSNR"), std::string::npos);
  const SplatLayer layer = read_layer(context.output() / "gaussians/diffuse.ply");
  EXPECT_LE(double(layer.size()), 700 * (1 + kMostUnseen));
  EXPECT_EQ(double(layer.size()), context.metrics.at("surfels"));
  const auto views = nlohmann::json::parse(read_file(context.output() / "optimize/views.json"));
  EXPECT_EQ(views["heldout"], nlohmann::json({"view_00.png", "view_06.png", "view_12.png"}));
  EXPECT_EQ(views["train"].size(), 15u);
  const auto report = nlohmann::json::parse(read_file(context.output() / "optimize/report.json"));
  EXPECT_EQ(report["iterations"], 300);
  EXPECT_LT(report["epochs"].back()["l1"].get<double>(), 0.5 * report["epochs"][0]["l1"].get<double>());
  EXPECT_TRUE(fs::exists(context.output() / "optimize/previews/step_000300.png"));
}

TEST_F(OptimizeStage, SameBytesForAnyNumberOfThreads) {
  Digest digests[3];
  const int threads[] = {1, 2, 5};
  for (int k = 0; k < 3; ++k) {
    OptimizeConfig config;
    shorten(config, 40);
    TestContext context(sfm(), work(fmt::format("threads{}", k)));
    context.thread_count = threads[k];
    run_optimize(config, context);
    digests[k] = digest_folder(context.output());
  }
  EXPECT_EQ(digests[0], digests[1]);
  EXPECT_EQ(digests[0], digests[2]);
}

TEST_F(OptimizeStage, KilledAtAnyStepItEndsWithTheSameBytes) {
  OptimizeConfig config;
  shorten(config, 45);
  TestContext whole(sfm(), work("whole"));
  run_optimize(config, whole);
  TestContext killed(sfm(), work("killed"));
  for (int stop : {3, 12, 13, 30, 44}) {
    killed.after_step = [stop](int step) {
      if (step == stop) throw Stopped{};
    };
    EXPECT_THROW(run_optimize(config, killed), Stopped);
  }
  killed.after_step = nullptr;
  run_optimize(config, killed);
  EXPECT_EQ(digest_folder(whole.output()), digest_folder(killed.output()));
  EXPECT_TRUE(killed.warnings.empty());
}

TEST_F(OptimizeStage, ASignalSavesTheStateAndEndsWithItsExitCode) {
  OptimizeConfig config;
  shorten(config, 40);
  config.checkpoint_every = 0;
  TestContext context(sfm(), work("signal"));
  EXPECT_EXIT(
      {
        install_interrupt_handlers();
        context.after_step = [](int step) {
          if (step == 23) std::raise(SIGINT);
        };
        int code = 0;
        try {
          run_optimize(config, context);
        } catch (const Error& e) {
          code = exit_code(e.kind());
        }
        _exit(code);
      },
      ::testing::ExitedWithCode(130), "");
  int first_step = 0;
  context.after_step = [&](int step) { first_step = first_step ? first_step : step; };
  context.timings.clear();
  run_optimize(config, context);
  EXPECT_EQ(first_step, 24);
  EXPECT_FALSE(context.timings.contains("stereo_seconds")) << "what training started from is known already";
}

TEST_F(OptimizeStage, ADamagedCheckpointIsReportedAndTrainingStartsOver) {
  OptimizeConfig config;
  shorten(config, 20);
  TestContext context(sfm(), work("damaged"));
  run_optimize(config, context);
  const Digest whole = digest_folder(context.output());
  const fs::path checkpoint = context.scratch() / "checkpoint.bin";
  std::string bytes = read_file(checkpoint);
  bytes[bytes.size() / 2] ^= 1;
  for (const std::string& damaged : {bytes, bytes.substr(0, 1000), bytes.substr(0, 10), std::string()}) {
    write_file(checkpoint, damaged);
    context.warnings.clear();
    run_optimize(config, context);
    EXPECT_EQ(context.warnings, std::vector<std::string>{"CHECKPOINT_IGNORED"});
    EXPECT_EQ(digest_folder(context.output()), whole);
  }
}

TEST_F(OptimizeStage, LittleMemoryMeansFewerSurfelsAndAnotherOptionOrAClearError) {
  OptimizeConfig config;
  shorten(config, 3);
  config.max_gaussians = 50000;
  const InputPaths inputs{{"sfm", sfm()}};
  EXPECT_TRUE(fit_into_memory(config, size_t(2) << 30, inputs).empty());
  const auto fitted = fit_into_memory(config, size_t(160) << 20, inputs);
  ASSERT_EQ(fitted.size(), 1u);
  EXPECT_EQ(fitted[0].path, "max_gaussians");
  EXPECT_EQ(fitted[0].code, "FEWER_SURFELS");
  config.max_gaussians = std::stoi(fitted[0].value);
  EXPECT_GT(config.max_gaussians, 2000);
  EXPECT_LT(config.max_gaussians, 10000);
  TestContext context(sfm(), work("memory"));
  context.memory = size_t(160) << 20;
  run_optimize(config, context);
  EXPECT_LE(context.metrics.at("surfels"), 1.2 * config.max_gaussians);
  context.memory = size_t(50) << 20;
  EXPECT_EQ(fit_into_memory(config, context.memory, inputs).at(0).value, "2000");
  try {
    run_optimize(config, context);
    FAIL() << "50 MiB are not enough";
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Resource);
    EXPECT_FALSE(e.detail().hint.empty());
  }
}

TEST_F(OptimizeStage, MissingPhotoAndWrongSizeAreErrorsWithTheFile) {
  OptimizeConfig config;
  shorten(config, 3);
  const fs::path broken = work("broken_sfm");
  write_tiny_sfm(broken, 4);
  write_exr_rgb(broken / "linear/view_02.exr", ImageF(20, 20, 3, 0.5f));
  TestContext context(broken, work("broken"));
  try {
    run_optimize(config, context);
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_NE(e.detail().where.find("view_02.exr"), std::string::npos);
  }
  fs::remove(broken / "linear/view_02.exr");
  EXPECT_THROW(run_optimize(config, context), Error);
}

TEST_F(OptimizeStage, WithoutTrainingPhotosItSaysSo) {
  OptimizeConfig config;
  shorten(config, 3);
  config.holdout_every = 1;
  TestContext context(sfm(), work("none"));
  EXPECT_THROW(run_optimize(config, context), Error);
}

TEST_F(OptimizeStage, ClassicAndFixedLayersLearnToo) {
  for (const DensifyStrategy strategy : {DensifyStrategy::Classic, DensifyStrategy::None}) {
    const char* name = strategy == DensifyStrategy::Classic ? "classic" : "none";
    OptimizeConfig config;
    shorten(config, 150);
    config.initial.stereo_side = kAllPixels;
    config.densify.strategy = strategy;
    TestContext context(sfm(), work(name));
    run_optimize(config, context);
    EXPECT_GT(context.metrics.at("heldout_psnr"), 17) << name;
  }
}

// What is no number enters in step 12: into a gradient, through a loss of which the run notices at once, or into positions, of
// which it notices when surfels are gone for ten steps. With checkpoints after every step the last good one is that of step 11.
TEST_F(OptimizeStage, AfterWhatIsNoNumberTheLastGoodCheckpointIsUsed) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
  OptimizeConfig sane;
  shorten(sane, 30);
  sane.checkpoint_every = 1;
  TestContext undisturbed(sfm(), work("undisturbed"));
  run_optimize(sane, undisturbed);
  const auto whole = digest_folder(undisturbed.output());
  struct Poison {
    const char *name, *code;
    std::function<void(OptimizeConfig&)> put;
  };
  const Poison poisons[] = {
      {"gradient", "LOSS_NOT_FINITE", [](OptimizeConfig& c) { c.loss.term("l1").schedule.weight = kNaN; }},
      {"positions", "GRADIENTS_NOT_FINITE", [](OptimizeConfig& c) { c.rates.rate[size_t(Attribute::Mean)] = kNaN; }}};
  for (const Poison& poison : poisons) {
    OptimizeConfig config;
    shorten(config, 30);
    config.checkpoint_every = 1;
    TestContext context(sfm(), work(poison.name));
    int last = 0;
    context.after_step = [&](int step) {
      last = step;
      if (step == 11) poison.put(config);
    };
    try {
      run_optimize(config, context);
      FAIL() << poison.name << " that are not numbers must end the run";
    } catch (const Error& e) {
      EXPECT_EQ(e.kind(), ErrorKind::Diverged);
      EXPECT_EQ(e.detail().code, poison.code);
      EXPECT_FALSE(e.detail().hint.empty());
    }
    EXPECT_GE(last, 11);
    EXPECT_TRUE(fs::is_empty(context.output())) << "nothing looks finished";
    int first = 0;
    context.after_step = [&](int step) { first = first == 0 ? step : first; };
    run_optimize(sane, context);
    EXPECT_EQ(first, 12) << poison.name << ": it continues behind the last good checkpoint";
    EXPECT_TRUE(context.warnings.empty()) << "the checkpoint is whole";
    EXPECT_EQ(digest_folder(context.output()), whole) << poison.name;
  }
}

TEST(Capture, NothingStandsNearerThanHalfTheNearestPoints) {
  ViewSet set;
  View view;
  view.intrinsics = {100, 100, 100, 100, 50, 50};
  set.views = {view};
  EXPECT_EQ(near_plane(set), 0.01f);  // nobody knows
  const auto points_at = [&](double z) {
    set.points.clear();
    for (int i = 0; i < 300; ++i) set.points.push_back({.position = {0, 0, z + 0.01 * i}});
    set.points.push_back({.position = {0, 0, -1}});     // behind the camera
    set.points.push_back({.position = {9, 0, 0.001}});  // outside the picture
  };
  points_at(0.1);
  EXPECT_NEAR(near_plane(set), 0.5 * 0.12, 1e-6);  // two in three hundred may be wrong
  points_at(3);
  EXPECT_EQ(near_plane(set), 0.1f);
  points_at(0.0001);
  EXPECT_NEAR(near_plane(set), 0.01f, 0.002);
}

// A scene that stands still in front of one photo: what changes from look to look is where the loss looks.
TEST(PerceptualTerm, LooksElsewhereEverySoManySteps) {
  const TemporaryFolder folder;
  const std::string weights = (folder.path() / "net.safetensors").string();
  testing::write_network(weights, testing::small_network());
  write_tiny_sfm(folder.path(), 2);
  OptimizeConfig config;
  shorten(config, 10);
  config.holdout_every = 2;
  config.resolution.quarter_until = config.resolution.half_until = 0;
  config.densify.strategy = DensifyStrategy::None;
  config.rates.rate.fill(0);
  for (LossTerm& term : config.loss.terms()) term.schedule = {.weight = term.factory->name == "perceptual" ? 1.f : 0.f};
  config.loss.term("perceptual").loss = make_perceptual_loss(weights, 24, 3);

  const Capture capture = load_capture(folder.path(), 0, config.holdout_every);
  ASSERT_EQ(capture.train.size(), 1u);
  const Targets targets = load_targets(capture, std::nullopt, {}, std::nullopt);
  const ShapeSet shapes;
  const TrainerSetup setup{
      .config = config, .capture = capture, .targets = targets, .shapes = shapes, .glass = shapes, .layers = {}};
  Trainer trainer(setup, initial_layer(config, capture, dense_depth(capture, 48, 2, 1), 600), {});
  std::vector<double> losses;
  for (int step = 0; step < 10; ++step) {
    trainer.step();
    losses.push_back(trainer.epochs().back().loss);  // one photo: every step ends an epoch
  }
  for (size_t step : {1, 2, 4, 5, 7, 8}) EXPECT_EQ(losses[step], 0) << step;
  EXPECT_GT(losses[0], 0);
  EXPECT_NE(losses[6], losses[3]);  // steps 0 and 3 draw the same place by chance
  EXPECT_NE(losses[9], losses[6]);
}

}  // namespace
}  // namespace vitrine
