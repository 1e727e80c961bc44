// A capture that is split by place: the plan of its blocks, and the scene that is joined from them.
#include "stages/optimize/blocks.h"

#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/json.h"
#include "core/foundation/base/parallel.h"
#include "core/learn/trainer/capture.h"
#include "core/render/picture/trained_scene.h"
#include "core/scene/surfels/splat_scene.h"
#include "tests/stages/optimize/test_context.h"
#include "tests/stages/optimize/tiny_capture.h"
#include "tests/support/error_of.h"

namespace vitrine {
namespace {

using testing::Stopped;
using testing::TestContext;
using testing::tiny_config;

std::vector<Vec3d> row_of_cameras(int count) {
  std::vector<Vec3d> centres;
  for (int i = 0; i < count; ++i) centres.push_back({0.1 * i, 0.2 * i, 0.5 * (i % 2)});
  return centres;
}

TEST(BlockCells, DivideTheCamerasEquallyAlongTheirRow) {
  const std::vector<Vec3d> centres = row_of_cameras(60);
  for (int blocks : {2, 3, 4, 5}) {
    const BlockCells cells(centres, blocks);
    ASSERT_EQ(cells.size(), size_t(blocks));
    std::vector<int> count(size_t(blocks), 0);
    size_t last = cells.cell_of(centres[0]);
    int changes = 0;
    for (const Vec3d& c : centres) {
      ++count[cells.cell_of(c)];
      changes += cells.cell_of(c) != last;
      last = cells.cell_of(c);
    }
    EXPECT_EQ(changes, blocks - 1) << "a cell is one stretch of the row";
    for (int n : count) EXPECT_EQ(n, 60 / blocks);
  }
}

TEST(BlockCells, OuterCellsHaveNoEndAndNoRoof) {
  const BlockCells cells(row_of_cameras(20), 2);
  const size_t first = cells.cell_of({0, 0, 0}), second = cells.cell_of({1.9, 3.8, 0});
  EXPECT_NE(first, second);
  EXPECT_EQ(cells.cell_of({-1000, -2000, 500}), first);
  EXPECT_EQ(cells.cell_of({1000, 2000, -500}), second);
}

TEST(BlockCells, CamerasInOnePlaceAreRefused) {
  const std::vector<Vec3d> centres(12, Vec3d{1, 2, 3});
  const Error error = error_of([&] { BlockCells(centres, 2); });
  EXPECT_EQ(error.kind(), ErrorKind::Usage);
  EXPECT_EQ(error.detail().code, "BLOCKS_NO_PLACE");
}

class Blocks : public ::testing::Test {
 protected:
  static constexpr int kViews = 30;
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder("blocks-test");
    testing::write_sfm_of(sfm(), testing::walk_along_hall(kViews, 48, 36), {.diffuse = testing::tiny_hall()});
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
    set_thread_limit(0);
  }
  static fs::path sfm() { return folder_->path() / "sfm"; }
  static fs::path work(const std::string& name) { return folder_->path() / name; }

  static void configure(OptimizeConfig& config, int blocks, int iterations) {
    config.iterations = iterations;
    config.max_gaussians = 3000;
    config.initial.frustum_points = 1500;
    config.initial.stereo_side = 24;
    config.densify.every = 10;
    config.checkpoint_every = 7;
    config.holdout_every = 6;
    config.blocks = blocks;
  }

 private:
  static TemporaryFolder* folder_;
};
TemporaryFolder* Blocks::folder_ = nullptr;

TEST_F(Blocks, EveryTrainingPhotoTrainsWhatItSeesAndNoHeldOutPhotoDoes) {
  const Capture cameras = load_cameras(sfm(), 6);
  const BlockPlan plan = planned_blocks(cameras.view_set, cameras.train, 2);
  ASSERT_EQ(plan.blocks.size(), 2u);
  for (uint32_t v : cameras.train) EXPECT_TRUE(plan.blocks[0].photos[v] || plan.blocks[1].photos[v]) << v;
  for (uint32_t v : cameras.heldout) EXPECT_FALSE(plan.blocks[0].photos[v] || plan.blocks[1].photos[v]) << v;
  const uint32_t first = cameras.train.front(), last = cameras.train.back();
  EXPECT_NE(plan.blocks[0].photos[first], plan.blocks[0].photos[last]) << "the ends of the hall are in different blocks";
  EXPECT_NE(plan.blocks[1].photos[first], plan.blocks[1].photos[last]);
  EXPECT_GT(plan.blocks[0].photo_count + plan.blocks[1].photo_count, cameras.train.size()) << "those at the cut train both";
}

TEST_F(Blocks, APartKeepsItsPointsTheNearPlaneAndTheHeldOutPhotos) {
  const Capture whole = load_capture(sfm(), 48, 6);
  std::vector<uint8_t> wanted(kViews, 0);
  for (size_t v : {size_t(0), size_t(1), size_t(7), size_t(12)}) wanted[v] = 1;
  const Capture part = load_part(sfm(), 48, 6, wanted);
  ASSERT_EQ(part.photos.size(), 4u);
  EXPECT_EQ(part.photos[2].levels[0].srgb, whole.photos[7].levels[0].srgb);
  EXPECT_EQ(part.heldout, (std::vector<uint32_t>{0, 3})) << "photos 0 and 12, as in the whole";
  EXPECT_EQ(part.near_z, whole.near_z);
  EXPECT_LT(part.memory_bytes, whole.memory_bytes / 7);
  size_t tracks = 0, expected = 0;
  for (const ScenePoint& p : part.view_set.points) tracks += p.views.size();
  for (const ScenePoint& p : whole.view_set.points)
    for (uint32_t v : p.views) expected += wanted[v];
  EXPECT_EQ(tracks, expected);
}

TEST_F(Blocks, TooManyBlocksAreRefused) {
  OptimizeConfig config;
  configure(config, 6, 10);
  TestContext context(sfm(), work("many"));
  const Error error = error_of([&] { run_optimize(config, context); });
  EXPECT_EQ(error.kind(), ErrorKind::Usage);
  EXPECT_EQ(error.detail().code, "BLOCKS_TOO_MANY");
  EXPECT_TRUE(fs::is_empty(context.output()));
}

TEST_F(Blocks, MasksOfAnObjectAreRefusedUnlessItStandsStill) {
  OptimizeConfig config;
  configure(config, 2, 10);
  TestContext context(sfm(), work("object"));
  context.masks = work("masks_of_object");
  make_folders(*context.masks / "masks/object");
  const Error error = error_of([&] { run_optimize(config, context); });
  EXPECT_EQ(error.detail().code, "BLOCKS_OF_OBJECT");
}

TEST(BlocksOptions, ExcludeLayersAndAMedium) {
  OptimizeConfig config;
  EXPECT_EQ(blocks_problem(config), "");
  config.layers = WantedLayers::Full;
  EXPECT_EQ(blocks_problem(config), "");
  config.blocks = 2;
  EXPECT_NE(blocks_problem(config).find("'layers'"), std::string::npos);
  config.layers = WantedLayers::Auto;
  EXPECT_EQ(blocks_problem(config), "");
  config.medium = WantedMedium::Water;
  EXPECT_NE(blocks_problem(config).find("'medium'"), std::string::npos);
}

// Of the joined scene, by its parts in the report: each has only surfels of its own side of the cut.
TEST_F(Blocks, JoinToASceneAsGoodAsThatOfOneTraining) {
  double psnr[2];
  for (int blocks : {1, 2}) {
    OptimizeConfig config;
    configure(config, blocks, 240);
    TestContext context(sfm(), work(fmt::format("good_{}", blocks)));
    run_optimize(config, context);
    psnr[blocks - 1] = context.metrics.at("heldout_psnr");
    EXPECT_TRUE(context.warnings.empty());
    EXPECT_EQ(context.last_progress.fraction, 1);
  }
  EXPECT_GT(psnr[0], 18);
  EXPECT_GT(psnr[1], psnr[0] - 0.5);
  EXPECT_EQ(read_file(work("good_1") / "output/optimize/views.json"), read_file(work("good_2") / "output/optimize/views.json"));
  const auto report = nlohmann::json::parse(read_file(work("good_2") / "output/optimize/report.json"));
  EXPECT_EQ(report["heldout"].size(), 5u);
  const TrainedScene scene = read_trained_scene(work("good_2") / "output");
  const SplatLayer& all = scene.surfels.diffuse;
  EXPECT_EQ(all.size(), report["surfels"].get<size_t>());
  EXPECT_EQ(scene.image.panes.mirrored, all.size() - report["unseen_surfels"].get<size_t>());
  const Capture cameras = load_cameras(sfm(), 6);
  const BlockPlan plan = planned_blocks(cameras.view_set, cameras.train, 2);
  size_t i = 0;
  for (size_t b = 0; b < 2; ++b) {
    const auto& facts = report["blocks"][b];
    const size_t seen = facts["surfels"].get<size_t>() - facts["unseen_surfels"].get<size_t>();
    EXPECT_GT(seen, 100u);
    EXPECT_LT(facts["surfels"], facts["trained_surfels"]) << "surfels outside the cell are left out";
    EXPECT_LT(facts["iterations"], 240);
    for (const size_t end = i + seen; i < end; ++i) {
      const float* m = all.at(Attribute::Mean, i);
      ASSERT_EQ(plan.cells.cell_of({m[0], m[1], m[2]}), b) << i;
    }
  }
}

TEST_F(Blocks, KilledInAnyBlockTheyEndWithTheSameBytesOnAnyNumberOfThreads) {
  OptimizeConfig config;
  configure(config, 2, 40);
  TestContext whole(sfm(), work("whole"));
  run_optimize(config, whole);
  TestContext killed(sfm(), work("killed"));
  killed.thread_count = 1;
  int first_blocks = 0;
  for (int stop : {9, 20}) {  // in the first block, in the second one
    int count = 0;
    killed.after_step = [&](int step) {
      first_blocks += step == 1 && killed.last_progress.text.starts_with("block 1");
      const bool there = killed.last_progress.text.starts_with(stop == 9 ? "block 1" : "block 2");
      if (there && ++count == stop) throw Stopped{};
    };
    EXPECT_THROW(run_optimize(config, killed), Stopped);
  }
  killed.after_step = [](int) {};
  run_optimize(config, killed);
  EXPECT_EQ(first_blocks, 1) << "a finished block is not trained again";
  EXPECT_EQ(digest_folder(whole.output()), digest_folder(killed.output()));
  EXPECT_TRUE(killed.warnings.empty());
}

}  // namespace
}  // namespace vitrine
