// Runs of more than one layer, on a tiny scene with a mirror whose photos our own image model took.
#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/parallel.h"
#include "core/observe/stereo/box_fit.h"
#include "core/observe/stereo/revolution_fit.h"
#include "core/render/model/thick_glass.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/shape/shape_file.h"
#include "core/scene/surfels/splat_scene.h"
#include "stages/optimize/optimize.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

using testing::Stopped;
using testing::TestContext;

OptimizeConfig layered_config(int iterations) {
  OptimizeConfig config = testing::tiny_config(iterations);
  config.checkpoint_every = 7;
  config.phases.reflection.hull_points = config.phases.transmittance.hull_points = 150;
  return config;
}

SurfaceOfRevolution tiny_ball() {
  SurfaceOfRevolution ball{{0, 0, 0}, {0, 0, 1}, {}};
  for (int i = 0; i <= 24; ++i) {
    const double polar = std::numbers::pi * i / 24;
    ball.profile.push_back({0.25 * std::sin(polar), -0.25 * std::cos(polar)});
  }
  return ball;
}

template <class Shape>
void write_glass_masks(const fs::path& masks, const Shape& shape) {
  fs::create_directories(masks / "masks/transparent");
  for (const View& view : testing::ring_of_views(18, 48, 36)) {
    const std::vector<uint8_t> inside = silhouette_mask(shape, view);
    Image8 mask(48, 36, 1);
    for (size_t i = 0; i < inside.size(); ++i) mask.data()[i] = inside[i] ? 255 : 0;
    write_ldr(masks / "masks/transparent" / (view.stem() + ".png"), mask);
  }
}

class LayeredRun : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder("layers-test");
    const fs::path sfm = folder_->path() / "sfm";
    testing::write_tiny_sfm(sfm, 18, 48, 36, testing::tiny_mirror_scene());
    test::write_objects_artifact(sfm, sfm, load_view_set(sfm).views);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
    set_thread_limit(0);
  }
  static TestContext context(const std::string& name) {
    TestContext c(folder_->path() / "sfm", folder_->path() / name);
    c.objects = folder_->path() / "sfm";
    return c;
  }
  // Killed before these steps, the run ends with the bytes of one that was left alone.
  static void expect_same_bytes(const OptimizeConfig& config, const TestContext& whole, TestContext& killed,
                                std::initializer_list<int> stops) {
    for (int stop : stops) {
      killed.after_step = [stop](int step) {
        if (step == stop) throw Stopped{};
      };
      EXPECT_THROW(run_optimize(config, killed), Stopped);
    }
    killed.after_step = nullptr;
    run_optimize(config, killed);
    EXPECT_EQ(digest_folder(whole.output()), digest_folder(killed.output()));
  }
  static TemporaryFolder* folder_;
};
TemporaryFolder* LayeredRun::folder_ = nullptr;

TEST_F(LayeredRun, KilledAtAnyStepOrOnOtherThreadsItEndsWithTheSameBytes) {
  OptimizeConfig config = layered_config(60);
  config.layers = WantedLayers::Full;
  config.phases.reflection.from = 0.3;
  config.phases.transmittance.from = 0.5;
  TestContext whole = context("whole");
  whole.thread_count = 1;
  run_optimize(config, whole);
  EXPECT_GT(read_layer(whole.output() / "gaussians/transmittance.ply").size(), 0u);
  TestContext killed = context("killed");
  killed.thread_count = 3;
  expect_same_bytes(config, whole, killed, {12, 18, 19, 29, 31, 59});  // layers begin at 18 and 30
}

// A case of glass in the middle of the scene, a known box: mirrored in, remembered by checkpoints and by the
// description of the scene.
TEST_F(LayeredRun, ACaseOfGlassSurvivesBeingKilled) {
  const Box box{Mat3d::identity(), {-0.22, -0.18, -0.2}, {0.2, 0.2, 0.25}};
  const fs::path masks = folder_->path() / "case";
  write_glass_masks(masks, box);
  const fs::path objects =
      test::write_objects_artifact(folder_->path() / "case objects", masks, load_view_set(folder_->path() / "sfm").views,
                                   test::one_object(box, ObjectRole::ThinGlass, 0.02));
  OptimizeConfig config = layered_config(60);
  config.layers = WantedLayers::Full;
  const auto context_of = [&](const std::string& name, int threads) {
    TestContext c = context(name);
    c.objects = objects;
    c.thread_count = threads;
    return c;
  };
  TestContext whole = context_of("whole case", 1), killed = context_of("killed case", 3);
  run_optimize(config, whole);
  const ImageOptions image = read_image_options(whole.output() / "optimize/model.json");
  ASSERT_TRUE(knows(image.shape.set.get(), ShapeRole::Sheet));
  const Box found = std::get<Box>(image.shape.set->entries.at(0).shape);
  for (size_t i = 0; i < 8; ++i) EXPECT_NEAR(found.distance(box.corner(i)), 0, 0.03) << "half a pixel is 0.01";
  EXPECT_LT(image.panes.mirrored, read_layer(whole.output() / "gaussians/diffuse.ply").size()) << "guesses are not mirrored";
  expect_same_bytes(config, whole, killed, {8, 10, 20, 45, 59});  // glass begins at 9
  config.shading.panes = false;
  TestContext plain = context_of("plain case", 2);
  run_optimize(config, plain);
  EXPECT_FALSE(knows(read_image_options(plain.output() / "optimize/model.json").shape.set.get(), ShapeRole::Sheet));
  EXPECT_NE(digest_folder(whole.output()), digest_folder(plain.output()));
}

// A block of solid glass: rays bend in it while the scene is trained, and in every program that reads the scene.
TEST_F(LayeredRun, ABlockOfGlassBendsRaysAndSurvivesBeingKilled) {
  const SurfaceOfRevolution ball = tiny_ball();
  const fs::path masks = folder_->path() / "block";
  write_glass_masks(masks, ball);
  const fs::path objects =
      test::write_objects_artifact(folder_->path() / "block objects", masks, load_view_set(folder_->path() / "sfm").views,
                                   test::one_object(ball, ObjectRole::SolidGlass, 0.02));
  OptimizeConfig config = layered_config(60);
  config.layers = WantedLayers::Full;
  TestContext whole = context("whole block"), killed = context("killed block");
  whole.objects = killed.objects = objects;
  whole.thread_count = 1, killed.thread_count = 3;
  run_optimize(config, whole);
  const ImageOptions image = read_image_options(whole.output() / "optimize/model.json");
  ASSERT_TRUE(knows(image.shape.set.get(), ShapeRole::Solid));
  ASSERT_TRUE(image.transmission.thick);
  EXPECT_TRUE(image.transmission.thick->contains({0, 0, 0.2f}));
  EXPECT_FALSE(image.transmission.thick->contains({0, 0, 0.3f}));
  expect_same_bytes(config, whole, killed, {8, 10, 20, 45, 59});  // glass begins at 9
}

// The ball as a coat: its shape is part of the scene, and does not learn.
TEST_F(LayeredRun, ACoatSurvivesBeingKilled) {
  const SurfaceOfRevolution ball = tiny_ball();
  const fs::path sfm = folder_->path() / "sfm";
  const fs::path objects = test::write_objects_artifact(folder_->path() / "coat", sfm, load_view_set(sfm).views,
                                                        test::one_object(ball, ObjectRole::Coat, 0.015));
  const auto context_of = [&](const std::string& name, int threads) {
    TestContext c = context(name);
    c.objects = objects;
    c.thread_count = threads;
    return c;
  };
  const OptimizeConfig config = layered_config(60);
  TestContext whole = context_of("whole coat", 1), killed = context_of("killed coat", 3);
  run_optimize(config, whole);
  const auto found = read_image_options(whole.output() / "optimize/model.json").shape.set;
  ASSERT_TRUE(knows(found.get(), ShapeRole::Coat));
  EXPECT_EQ(found->entries.at(0).role, ShapeRole::Coat);
  const auto& learnt = std::get<SurfaceOfRevolution>(found->entries.at(0).shape).profile;
  for (size_t i = 0; i < ball.profile.size(); ++i) EXPECT_NEAR(learnt.at(i).x, ball.profile[i].x, 1e-9);
  expect_same_bytes(config, whole, killed, {17, 18, 19, 40, 59});  // reflection begins at 18
}

TEST_F(LayeredRun, GuessedObjectsAskForNoLayers) {
  const fs::path sfm = folder_->path() / "sfm";
  const auto has_reflection = [&](ObjectTrust trust, WantedLayers layers = WantedLayers::Auto) {
    const std::string word(name(trust));
    const ObjectSet set{.objects = {{.id = 1, .name = "ball", .role = ObjectRole::Mirror, .trust = trust}}, .shapes = {}};
    OptimizeConfig config = layered_config(8);
    config.layers = layers;
    config.fill_unseen = false;
    TestContext c = context(fmt::format("{} {}", word, int(layers)));
    c.objects = test::write_objects_artifact(folder_->path() / (word + " objects"), sfm, load_view_set(sfm).views, set);
    run_optimize(config, c);
    return fs::exists(c.output() / "gaussians/reflection.ply");
  };
  EXPECT_TRUE(has_reflection(ObjectTrust::Given));
  EXPECT_TRUE(has_reflection(ObjectTrust::Marked));
  EXPECT_TRUE(has_reflection(ObjectTrust::Detected));
  EXPECT_FALSE(has_reflection(ObjectTrust::Guessed));
  EXPECT_TRUE(has_reflection(ObjectTrust::Guessed, WantedLayers::Full)) << "everything may reflect";
}

// What is guessed changes nothing: the same bytes as without objects.
TEST_F(LayeredRun, AGuessedObjectLeavesNoTrace) {
  const fs::path sfm = folder_->path() / "sfm";
  ObjectSet set = test::one_object(Box{Mat3d::identity(), {-0.2, -0.2, -0.2}, {0.2, 0.2, 0.2}}, ObjectRole::Mirror, 0.02);
  set.objects[0].trust = ObjectTrust::Guessed;
  TestContext guessed = context("leaves no trace"), none = context("without objects");
  guessed.objects = test::write_objects_artifact(folder_->path() / "guess", sfm, load_view_set(sfm).views, set);
  none.objects = std::nullopt;
  const OptimizeConfig config = layered_config(8);
  run_optimize(config, guessed);
  run_optimize(config, none);
  EXPECT_EQ(digest_folder(guessed.output()), digest_folder(none.output()));
}

TEST_F(LayeredRun, MasksThatFitNoPhotoAreErrors) {
  OptimizeConfig config = layered_config(3);
  const auto code_of = [&](const fs::path& masks) {
    TestContext c = context("bad");
    c.objects = std::nullopt, c.masks = masks;
    try {
      run_optimize(config, c);
    } catch (const Error& e) {
      return e.kind() == ErrorKind::Input ? e.detail().code : std::string("another kind");
    }
    return c.warnings.empty() ? std::string() : c.warnings.front();
  };
  const fs::path folder = folder_->path();
  write_ldr(folder / "strange/masks/ignore/nobody.png", Image8(48, 36, 1, 255));
  EXPECT_EQ(code_of(folder / "strange"), "MASKS_MATCH_NO_PHOTO");
  write_ldr(folder / "small/masks/ignore/view_03.png", Image8(24, 18, 1, 255));
  EXPECT_EQ(code_of(folder / "small"), "MASK_SIZE");
  for (const View& view : testing::ring_of_views(18, 48, 36)) {
    write_ldr(folder / "black/masks/ignore" / (view.stem() + ".png"), Image8(48, 36, 1, 0));
    write_ldr(folder / "white/masks/ignore" / (view.stem() + ".png"), Image8(48, 36, 1, 255));
    write_ldr(folder / "glass/masks/transparent" / (view.stem() + ".png"), Image8(48, 36, 1, 255));
  }
  EXPECT_EQ(code_of(folder / "black"), "MASK_EMPTY");
  EXPECT_EQ(code_of(folder / "white"), "MASK_COVERS_MOST");
  TestContext everywhere = context("glass everywhere");
  everywhere.objects = test::write_objects_artifact(folder / "glass", folder / "glass", load_view_set(folder / "sfm").views);
  run_optimize(config, everywhere);
  ASSERT_FALSE(everywhere.warnings.empty());
  EXPECT_EQ(everywhere.warnings.front(), "MASK_COVERS_MOST");
}

}  // namespace
}  // namespace vitrine
