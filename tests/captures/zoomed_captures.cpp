// Photos of one size and two focal lengths without EXIF, through ingest and sfm with the real COLMAP.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/foundation/base/json.h"
#include "core/scene/camera/colmap_model.h"
#include "core/scene/camera/view_set.h"
#include "stages/ingest/ingest.h"
#include "stages/sfm/sfm.h"
#include "tests/captures/studio.h"
#include "tests/support/pose_errors.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using test::pose_errors, test::PoseErrors, test::RecordingContext, test::Studio;

// Photos around the boxes; number i has focals[i % focals.size()] pixels of focal length.
class Zoomed {
 public:
  Zoomed(size_t photos, const std::vector<double>& focals) {
    constexpr int kWide = 320, kHigh = 240;
    const Studio studio({});
    make_folders(folder_.path());
    for (size_t i = 0; i < photos; ++i) {
      const double a = 0.3 + 0.08 * double(i) * std::numbers::pi, f = focals[i % focals.size()];
      const Vec3d eye{1.5 * std::cos(a), 1.5 * std::sin(a), 0.7 + 0.25 * double(i % 3)};
      truth_.push_back({.name = fmt::format("photo_{:02}.png", i),
                        .intrinsics = {kWide, kHigh, f, f, kWide / 2.0, kHigh / 2.0},
                        .cam_from_world = generate::looking_at(eye, {0.05 * double(i % 2), 0, 0.25}, {0, 0, 1})});
      write_ldr(folder_.path() / truth_.back().name, srgb8_from_linear(studio.linear(truth_.back())));
    }
    RecordingContext ingest({{"photos", folder_.path()}});
    ingest_stage().run(ingest);
    sfm = std::make_unique<RecordingContext>(std::map<std::string, fs::path>{{"ingest", ingest.output()}});
    Stage stage = sfm_stage();
    stage.options.find("max_features")->assign("1200", "test");  // fewer are faster
    stage.run(*sfm);
  }
  ColmapModel model() const { return read_colmap_model(sfm->output() / "sparse/0"); }
  nlohmann::json report() const { return nlohmann::json::parse(read_file(sfm->output() / "sfm/report.json")); }
  PoseErrors errors() const { return pose_errors(load_view_set(sfm->output()).views, truth_); }
  std::unique_ptr<RecordingContext> sfm;

 private:
  TemporaryFolder folder_{"zoomed"};
  std::vector<View> truth_;
};

TEST(Zoomed, TwoFocalLengthsWithoutExifHaveACameraEach) {
  const Zoomed capture(12, {250, 425});
  ColmapModel model = capture.model();
  EXPECT_EQ(model.images.size(), 12u);
  ASSERT_EQ(model.cameras.size(), 2u);
  for (size_t i = 0; i < model.images.size(); ++i) {
    const double truth = i % 2 == 0 ? 250 : 425;
    EXPECT_NEAR(model.find_camera(model.images[i].camera_id)->params[0], truth, 0.02 * truth) << i;
  }
  const PoseErrors e = capture.errors();
  fmt::print("worst centre {:.4f} of the ring, worst rotation {:.3f} degrees\n", e.centre_rel, e.rotation_deg);
  EXPECT_LT(e.centre_rel, 0.02);
  EXPECT_LT(e.rotation_deg, 0.5);
  const nlohmann::json focals = capture.report()["focal_lengths"];
  EXPECT_EQ(focals["found"], "several");
  EXPECT_EQ(focals["cameras"].size(), 2u);
  EXPECT_LT(focals["error_after_px"], 0.7 * focals["error_before_px"].get<double>());
}

TEST(Zoomed, OneFocalLengthIsOneCamera) {
  const Zoomed capture(7, {300});
  EXPECT_EQ(capture.model().images.size(), 7u);
  EXPECT_EQ(capture.model().cameras.size(), 1u);
  EXPECT_FALSE(capture.report().contains("focal_lengths"));
}

}  // namespace
}  // namespace vitrine
