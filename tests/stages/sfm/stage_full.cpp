// Whole runs of the stage with the real COLMAP on real photographs (../shared/data); each skips when its set is not on the
// machine.
#include <gtest/gtest.h>

#include <cstdlib>

#include "core/foundation/base/error.h"
#include "core/foundation/base/hash.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/scene_info.h"
#include "core/scene/camera/view_set.h"
#include "stages/sfm/sfm.h"
#include "tests/stages/sfm/sfm_support.h"
#include "tests/support/pose_errors.h"

namespace vitrine {
namespace {

using test::pose_errors, test::PoseErrors;

fs::path data_set(const std::string& name) {
  const char* named = std::getenv("VITRINE_DATA");
  return (named != nullptr ? fs::path(named) : fs::path(VITRINE_SOURCE_DIR) / ".." / "shared" / "data") / name;
}

#define NEED_DATA(name) \
  if (!fs::is_directory(data_set(name))) GTEST_SKIP() << "the data set ../shared/data/" << (name) << " is not on this machine"

// Every n-th picture of a folder, linked.
fs::path every_nth(const fs::path& from, const fs::path& to, size_t n) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(from)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  make_folders(to);
  for (size_t i = 0; i < files.size(); i += n) fs::create_symlink(files[i], to / files[i].filename());
  return to;
}

// Runs the stage on an ingest artifact; returns the context with its figures.
std::unique_ptr<RecordingContext> run_sfm(std::map<std::string, fs::path> inputs, const fs::path& folder, int threads,
                                          const std::map<std::string, std::string>& options = {}) {
  Stage stage = sfm_stage();
  for (const auto& [path, value] : options) stage.options.find(path)->assign(value, "test");
  auto context = std::make_unique<RecordingContext>(std::move(inputs), folder, threads);
  stage.run(*context);
  return context;
}

TEST(SfmStage, BlenderPhotosGetTheirTruePosesAndTheSameBytesForOneAndTwoThreads) {
  NEED_DATA("vitrine_blender");
  const TemporaryFolder folder;
  const fs::path ingest = folder.path() / "ingest artifact";  // with a space
  make_ingest(data_set("vitrine_blender/photos"), ingest);
  const auto two = run_sfm({{"ingest", ingest}}, folder.path() / "two", 2);
  EXPECT_EQ(two->metrics.at("registered"), 42);
  EXPECT_LT(two->metrics.at("reprojection_px"), 0.5);

  const ViewSet views = load_view_set(two->output());
  const PoseErrors e = pose_errors(views.views, read_transforms_json(data_set("vitrine_blender/truth/transforms.json")));
  std::cout << "worst rotation " << e.rotation_deg << " deg, worst centre " << e.centre_rel << " of the ring, up off by "
            << e.up_deg << " deg\n";
  EXPECT_LT(e.rotation_deg, 0.1);
  EXPECT_LT(e.centre_rel, 0.003);
  EXPECT_LT(e.up_deg, 1.0);

  // What any trainer reads: both formats of the model, and transforms.json, describe the same cameras.
  const ColmapModel binary = read_colmap_model(two->output() / "sparse/0", ColmapFormat::Binary),
                    text = read_colmap_model(two->output() / "sparse/0", ColmapFormat::Text);
  EXPECT_EQ(binary, text);
  const std::vector<View> nerf = read_transforms_json(two->output() / "transforms.json");
  ASSERT_EQ(nerf.size(), views.views.size());
  for (size_t i = 0; i < nerf.size(); ++i) {
    EXPECT_LT(length(nerf[i].centre_in_world() - views.views[i].centre_in_world()), 1e-6);
    EXPECT_TRUE(fs::exists(two->output() / "images" / views.views[i].name));
    EXPECT_TRUE(fs::exists(linear_image_path(two->output(), views.views[i])));
  }

  const auto one = run_sfm({{"ingest", ingest}}, folder.path() / "one", 1);
  EXPECT_EQ(digest_folder(one->output()), digest_folder(two->output()));

  // The result given back as poses: nothing is matched, everything is kept.
  const auto again = run_sfm({{"ingest", ingest}, {"poses", two->output()}}, folder.path() / "again", 2);
  EXPECT_EQ(again->metrics.at("registered"), 42);
  EXPECT_FALSE(again->timings.contains("match"));
  EXPECT_GT(again->metrics.at("points"), 0.95 * two->metrics.at("points"));
  // The truth given as poses without points: they are triangulated, and the cameras stay where they were put.
  const auto given =
      run_sfm({{"ingest", ingest}, {"poses", data_set("vitrine_blender/truth/transforms.json")}}, folder.path() / "given", 2);
  EXPECT_EQ(given->metrics.at("registered"), 42);
  EXPECT_GT(given->metrics.at("points"), 0.5 * two->metrics.at("points"));
  const PoseErrors g =
      pose_errors(load_view_set(given->output()).views, read_transforms_json(data_set("vitrine_blender/truth/transforms.json")));
  EXPECT_LT(g.rotation_deg, 1e-4);
  EXPECT_LT(g.centre_rel, 1e-6);
}

TEST(SfmStage, ChromeFromSevenWideViewsEndsWithExitCode4) {
  NEED_DATA("espresso");
  const TemporaryFolder folder;
  make_ingest(data_set("espresso/images"), folder.path() / "ingest");
  try {
    run_sfm({{"ingest", folder.path() / "ingest"}}, folder.path(), 2);
    FAIL() << "accepted";
  } catch (const Error& e) {
    std::cout << e.what() << "\n";
    EXPECT_EQ(exit_code(e.kind()), 4);
    EXPECT_TRUE(e.detail().code.starts_with("SFM_"));
    EXPECT_FALSE(e.detail().hint.empty());
    EXPECT_TRUE(fs::exists(e.detail().where));
  }
}

TEST(SfmStage, PhotosWithoutOverlapEndWithExitCode4) {
  NEED_DATA("plush");
  const TemporaryFolder folder;
  // Every twelfth photo of an orbit: too far apart for the same features.
  make_ingest(every_nth(data_set("plush/images"), folder.path() / "few", 12), folder.path() / "ingest", 640);
  try {
    run_sfm({{"ingest", folder.path() / "ingest"}}, folder.path(), 2, {{"retries", "0"}});
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(exit_code(e.kind()), 4);
    EXPECT_NE(e.detail().why.find("features"), std::string::npos);
  }
}

TEST(SfmStage, BuddhaRunsFromItsGivenMatrices) {
  NEED_DATA("buddha13");
  const TemporaryFolder folder;
  make_ingest(data_set("buddha13/images"), folder.path() / "ingest");
  const auto context = run_sfm({{"ingest", folder.path() / "ingest"}, {"poses", data_set("buddha13/P")}}, folder.path(), 2);
  EXPECT_EQ(context->metrics.at("registered"), 13);
  EXPECT_GT(context->metrics.at("points"), 200);
  EXPECT_LT(context->metrics.at("reprojection_px"), 2);
}

}  // namespace
}  // namespace vitrine
