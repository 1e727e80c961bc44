// Runs of more than one layer, on a tiny scene with a mirror whose photos our own image model took.
#include <gtest/gtest.h>

#include "core/base/hash.h"
#include "core/base/parallel.h"
#include "core/picture/trained_scene.h"
#include "core/scene/scene_io.h"
#include "stages/optimize/optimize.h"
#include "tests/optimize/test_context.h"
#include "tests/optimize/tiny_capture.h"

namespace vitrine {
namespace {

using testing::Stopped;
using testing::TestContext;

OptimizeConfig short_config(int iterations) {
  OptimizeConfig config;
  config.iterations = iterations;
  config.max_gaussians = 1500;
  config.initial.frustum_points = 500;
  config.initial.stereo_side = 48;
  config.densify.every = 10;
  config.preview_every = 0;
  config.checkpoint_every = 7;
  config.holdout_every = 6;
  config.phases.reflection.hull_points = config.phases.transmittance.hull_points = 150;
  return config;
}

class LayeredRun : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder("layers-test");
    testing::write_tiny_sfm(folder_->path() / "sfm", 18, 48, 36, testing::tiny_mirror_scene());
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
    set_thread_limit(0);
  }
  static TestContext context(const std::string& name) {
    TestContext c(folder_->path() / "sfm", folder_->path() / name);
    c.masks = folder_->path() / "sfm";
    return c;
  }
  // PSNR inside the mirror, over the held-out photos, of what a reader of the artifact renders.
  static double mirror_psnr(const fs::path& artifact) {
    const TrainedScene trained = read_trained_scene(artifact);
    LayeredModel model(trained.image);
    double sum = 0, count = 0;
    Frame frame;
    const std::vector<View> views = testing::ring_of_views(18, 48, 36);
    for (size_t v = 0; v < views.size(); v += 6) {
      model.forward(trained.surfels, views[v], frame);
      const ImageF photo = srgb_from_linear_image(read_exr_rgb(linear_image_path(folder_->path() / "sfm", views[v])));
      const Image8 mask = read_grey8(folder_->path() / "sfm/masks/specular" / (views[v].stem() + ".png"));
      const size_t pixels = photo.pixel_count();
      for (size_t i = 0; i < pixels; ++i)
        for (size_t c = 0; c < 3; ++c) {
          const double d = frame.srgb[c * pixels + i] - std::clamp(photo.data()[3 * i + c], 0.f, 1.f);
          if (mask.data()[i] < 128) continue;
          sum += d * d;
          count += 1;
        }
    }
    return -10 * std::log10(sum / count);
  }
  static TemporaryFolder* folder_;
};
TemporaryFolder* LayeredRun::folder_ = nullptr;

TEST_F(LayeredRun, AReflectionLayerShowsWhatAMirrorShows) {
  OptimizeConfig config = short_config(400);
  config.layers = "diffuse";
  TestContext alone = context("alone");
  run_optimize(config, alone);
  EXPECT_FALSE(fs::exists(alone.output() / "gaussians/reflection.ply"));
  config.layers = "auto";
  TestContext layered = context("layered");
  run_optimize(config, layered);
  EXPECT_FALSE(fs::exists(layered.output() / "gaussians/transmittance.ply"));
  const size_t surfels = read_layer(layered.output() / "gaussians/diffuse.ply").size() +
                         read_layer(layered.output() / "gaussians/reflection.ply").size();
  EXPECT_LE(surfels, 1500u);
  const double before = mirror_psnr(alone.output()), after = mirror_psnr(layered.output());
  RecordProperty("mirror_gain", std::to_string(after - before));
  // Measured +0.97 dB: 400 steps on photos of 48x36 pixels. The rest of the picture is not judged here: at this size the hull of
  // the mirror's masks is wider than the mirror and hides what stands beside it.
  EXPECT_GT(after, before + 0.5) << before;
}

TEST_F(LayeredRun, KilledAtAnyStepOrOnOtherThreadsItEndsWithTheSameBytes) {
  OptimizeConfig config = short_config(60);
  config.layers = "full";
  config.phases.reflection.from = 0.3;
  config.phases.transmittance.from = 0.5;
  TestContext whole = context("whole");
  whole.thread_count = 1;
  run_optimize(config, whole);
  EXPECT_GT(read_layer(whole.output() / "gaussians/transmittance.ply").size(), 0u);
  TestContext killed = context("killed");
  killed.thread_count = 3;
  for (int stop : {12, 18, 19, 29, 31, 59}) {  // layers begin at 18 and 30
    killed.after_step = [stop](int step) {
      if (step == stop) throw Stopped{};
    };
    EXPECT_THROW(run_optimize(config, killed), Stopped);
  }
  killed.after_step = nullptr;
  run_optimize(config, killed);
  EXPECT_EQ(digest_folder(whole.output()), digest_folder(killed.output()));
}

TEST_F(LayeredRun, MasksThatFitNoPhotoAreErrors) {
  OptimizeConfig config = short_config(3);
  const auto code_of = [&](const fs::path& masks) {
    TestContext c = context("bad");
    c.masks = masks;
    try {
      run_optimize(config, c);
    } catch (const Error& e) {
      return e.kind() == ErrorKind::Input ? e.detail().code : std::string("another kind");
    }
    return c.warnings.empty() ? std::string() : c.warnings.front();
  };
  const fs::path folder = folder_->path();
  write_ldr(folder / "strange/masks/specular/nobody.png", Image8(48, 36, 1, 255));
  EXPECT_EQ(code_of(folder / "strange"), "MASKS_MATCH_NO_PHOTO");
  write_ldr(folder / "small/masks/specular/view_03.png", Image8(24, 18, 1, 255));
  EXPECT_EQ(code_of(folder / "small"), "MASK_SIZE");
  for (const View& view : testing::ring_of_views(18, 48, 36)) {
    write_ldr(folder / "black/masks/specular" / (view.stem() + ".png"), Image8(48, 36, 1, 0));
    write_ldr(folder / "white/masks/ignore" / (view.stem() + ".png"), Image8(48, 36, 1, 255));
  }
  EXPECT_EQ(code_of(folder / "black"), "MASK_EMPTY");
  EXPECT_EQ(code_of(folder / "white"), "MASK_COVERS_MOST");
}

}  // namespace
}  // namespace vitrine
