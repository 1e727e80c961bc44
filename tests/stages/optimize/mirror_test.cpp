// What a reflection layer is for: a curved mirror, seen by held-out photos.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/camera/view_set.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/optimize.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using testing::TestContext;

// PSNR inside the mirror, over the held-out photos, of what a reader of the artifact renders.
double mirror_psnr(const fs::path& sfm, const fs::path& artifact) {
  const TrainedScene trained = read_trained_scene(artifact);
  LayeredModel model(trained.image);
  double sum = 0, count = 0;
  Frame frame;
  const std::vector<View> views = testing::ring_of_views(18, 48, 36);
  for (size_t v = 0; v < views.size(); v += 6) {
    model.forward(trained.surfels, views[v], frame);
    const ImageF photo = srgb_from_linear_image(read_exr_rgb(linear_image_path(sfm, views[v])));
    const Image8 mask = read_grey8(sfm / "masks/specular" / (views[v].stem() + ".png"));
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

// An artifact of the objects stage with a ball that mirrors, its radius wavy by `off`.
fs::path known_ball(const fs::path& sfm, const fs::path& artifact, const Vec3d& centre, double off) {
  SurfaceOfRevolution ball{centre, {0, 0, 1}, {}};
  for (int i = 0; i <= 48; ++i) {
    const double polar = std::numbers::pi * i / 48, radius = 0.25 + off * std::sin(9 * polar);
    ball.profile.push_back({radius * std::sin(polar), -radius * std::cos(polar)});
  }
  return test::write_objects_artifact(artifact, sfm, load_view_set(sfm).views, test::one_object(ball, ObjectRole::Mirror, 0.015));
}

TEST(MirrorRun, AReflectionLayerShowsWhatAMirrorShows) {
  const TemporaryFolder folder("mirror-test");
  const fs::path sfm = folder.path() / "sfm";
  testing::write_tiny_sfm(sfm, 18, 48, 36, testing::tiny_mirror_scene());
  const fs::path objects = known_ball(sfm, folder.path() / "found", {0, 0, 0}, 0);
  OptimizeConfig config = testing::tiny_config(1000);
  config.initial.stereo_side = 48;
  config.phases.reflection.hull_points = 150;
  config.phases.reflection.share = 0.4;
  config.phases.reflection.from = 0.1;
  config.phases.reflection.surface_from = 0.2;
  config.opaque_twin = false;  // the layers by themselves

  // Pictures so small are a matter of luck, by half a decibel and now and then much more: three seeds.
  std::vector<double> before, after;
  for (int seed : {1, 2, 3}) {
    const fs::path work = folder.path() / std::to_string(seed);
    config.seed = seed;
    config.layers = WantedLayers::Diffuse;
    TestContext alone(sfm, work / "alone");
    run_optimize(config, alone);
    EXPECT_FALSE(fs::exists(alone.output() / "gaussians/reflection.ply"));
    config.layers = WantedLayers::Auto;
    TestContext layered(sfm, work / "layered");
    layered.objects = objects;
    run_optimize(config, layered);
    EXPECT_FALSE(fs::exists(layered.output() / "gaussians/transmittance.ply"));
    const size_t surfels = read_layer(layered.output() / "gaussians/diffuse.ply").size() +
                           read_layer(layered.output() / "gaussians/reflection.ply").size();
    const auto report = nlohmann::json::parse(read_file(layered.output() / "optimize/report.json"));
    const size_t guessed = report.at("unseen_surfels").get<size_t>();
    EXPECT_LE(surfels - guessed, 1500u);
    EXPECT_LE(guessed, 300u) << "a fifth of the others";
    before.push_back(mirror_psnr(sfm, alone.output())), after.push_back(mirror_psnr(sfm, layered.output()));
  }
  std::sort(before.begin(), before.end()), std::sort(after.begin(), after.end());
  RecordProperty("mirror_gain", std::to_string(after[1] - before[1]));
  // Measured 18.3 -> 18.8 with AVX2 (five seeds: 18.4 -> 18.9): a diffuse layer does well on a ball, by a picture inside it, the
  // more so since the rim, which it cannot show, mirrors less in the photos, too.
  EXPECT_GT(after[1], before[1] + 0.3) << ::testing::PrintToString(before) << " -> " << ::testing::PrintToString(after);
}

// The ball as silhouettes tell it, a pixel off here and there: it follows what it mirrors, and is remembered by checkpoints and
// by the description of the scene.
TEST(MirrorRun, ASolidFollowsWhatItMirrorsAndSurvivesBeingKilled) {
  const TemporaryFolder folder("solid-test");
  const fs::path sfm = folder.path() / "sfm";
  testing::write_tiny_sfm(sfm, 18, 144, 108, testing::tiny_mirror_scene());
  const fs::path artifact = known_ball(sfm, folder.path() / "found", {0.003, -0.002, 0}, 0.004);
  OptimizeConfig config = testing::tiny_config(120);
  config.initial.stereo_side = 48;
  config.checkpoint_every = 20;
  config.phases.reflection.from = 0.2;
  config.phases.reflection.surface_from = 0.25;
  const auto run = [&](const char* name, int threads, std::initializer_list<int> twin_stops, std::initializer_list<int> stops) {
    TestContext context(sfm, folder.path() / name);
    context.objects = artifact;
    context.thread_count = threads;
    const auto stopped = [&](std::function<void(int)>& called, std::initializer_list<int> at) {
      for (int stop : at) {
        called = [stop](int step) {
          if (step == stop) throw testing::Stopped{};
        };
        EXPECT_THROW(run_optimize(config, context), testing::Stopped);
      }
      called = nullptr;
    };
    stopped(context.after_twin_step, twin_stops), stopped(context.after_step, stops);
    run_optimize(config, context);
    return context.output();
  };
  const auto shapes = [](const fs::path& artifact) {
    const auto found = read_image_options(artifact / "optimize/model.json").shape.set;
    return found ? found->entries : std::vector<ShapeSet::Entry>();
  };
  const fs::path whole = run("whole", 1, {}, {});
  ASSERT_EQ(shapes(whole).size(), 1u);
  EXPECT_EQ(digest_folder(whole), digest_folder(run("killed", 3, {7, 65, 120}, {1, 23, 25, 31, 90, 107, 109, 120})));
  // Off the ball by how much, in the mean over its profile.
  const auto off = [&](const fs::path& artifact) {
    const auto s = std::get<SurfaceOfRevolution>(shapes(artifact).at(0).shape);
    double sum = 0, count = 0;
    for (const Vec2d& p : s.profile)
      for (double turn = 0; turn < 6; turn += 0.5) {
        const Vec3d u = normalized(cross(s.axis, Vec3d{1, 0, 0})), v = cross(s.axis, u);
        const Vec3d at = s.origin + p.y * s.axis + p.x * (std::cos(turn) * u + std::sin(turn) * v);
        if (at.z < 0.05) continue;  // mirrors the table
        sum += std::abs(length(at) - 0.25), ++count;
      }
    return sum / count;
  };
  // The ball mirrors a dome that no photo shows, and finds it out while its own shape is learnt: that must not lead it astray.
  EXPECT_LT(off(whole), 0.005) << "a pixel is 0.008";
  // The opaque twin was trained, and photos have judged it.
  const TrainedScene trained = read_trained_scene(whole);
  EXPECT_GT(trained.surfels.opaque.size(), 100u);
  EXPECT_EQ(trained.image.opaque.layered, 0.5f);
  EXPECT_LT(shapes(whole)[0].layered, 1) << "120 steps are few for a reflection layer";
  config.opaque_twin = false;
  const TrainedScene alone = read_trained_scene(run("alone", 2, {}, {}));
  EXPECT_EQ(alone.surfels.opaque.size(), 0u);
  EXPECT_EQ(alone.image.opaque.layered, 1);
  config.shading.shapes = false;
  EXPECT_TRUE(shapes(run("surfels", 2, {}, {})).empty());
}

}  // namespace
}  // namespace vitrine
