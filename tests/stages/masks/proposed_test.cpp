// Proposals: display cases are found where they are, and an opaque scene is left alone.
#include <gtest/gtest.h>

#include "core/foundation/config/json_file.h"
#include "stages/masks/masks.h"
#include "tests/stages/optimize/tiny_capture.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

constexpr int kPhotoWidth = 64, kPhotoHeight = 48;

// Cameras around a floor at z = -0.3, which stereo finds everywhere.
struct FloorCapture {
  std::vector<View> views = testing::ring_of_views(16, kPhotoWidth, kPhotoHeight);
  std::vector<DepthMap> maps;

  FloorCapture() {
    for (const View& view : views) {
      const size_t pixels = kPhotoWidth * kPhotoHeight;
      DepthMap seen{.width = kPhotoWidth,
                    .height = kPhotoHeight,
                    .zdepth = std::vector<float>(pixels),
                    .normal = {},
                    .score = {},
                    .agreeing = {},
                    .trusted = std::vector<uint8_t>(pixels, 1)};
      const Rigid world_from_cam = inverse(view.cam_from_world);
      for (int y = 0; y < kPhotoHeight; ++y)
        for (int x = 0; x < kPhotoWidth; ++x) {
          const Vec3d d = world_from_cam.rotation * view.intrinsics.ray(x + 0.5, y + 0.5);
          const double z = (-0.3 - world_from_cam.translation.z) / d.z;
          seen.zdepth[size_t(y * kPhotoWidth + x)] = z > 0 && z < 4 ? float(z) : 100.f;
        }
      maps.push_back(std::move(seen));
    }
  }
};

// A box on the floor, 0.3 wide, seen exactly: opaque, or as if it were not there; in it stands a smaller one.
StandingBox box_on_the_floor() {
  StandingBox standing{
      {.axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .low = {-0.15, -0.15, -0.2}, .high = {0.15, 0.15, 0.1}}, 40, 10};
  return standing;
}
void stand(FloorCapture& c, const Box& box) {
  for (size_t v = 0; v < c.views.size(); ++v) {
    const View& view = c.views[v];
    for (int y = 0; y < kPhotoHeight; ++y)
      for (int x = 0; x < kPhotoWidth; ++x) {
        const Vec3d ray = view.ray(x + 0.5, y + 0.5);
        if (const auto crossing = box.crossing(view.centre_in_world(), ray))
          c.maps[v].zdepth[size_t(y * kPhotoWidth + x)] = float(crossing->in);
      }
  }
}

TEST(DisplayCases, AreSeenThroughFromAllSidesAndStandOnWhatIsBelow) {
  FloorCapture c;
  Box figure = box_on_the_floor().box;
  figure.low = {-0.05, -0.05, -0.3}, figure.high = {0.05, 0.05, 0};
  stand(c, figure);
  const std::vector<StandingBox> boxes{box_on_the_floor(), box_on_the_floor()};  // found twice
  const auto cases = display_cases(boxes, c.views, c.maps);
  ASSERT_EQ(cases.size(), 1u);
  EXPECT_NEAR(cases[0].box.low.z, -0.3, 0.01) << "its edges began to show a third of its height above the floor";
  EXPECT_GT(cases[0].seen_through, 0.95);
  // Something stands before it in one photo.
  const View& view = c.views[2];
  const size_t middle = size_t(kPhotoHeight / 2 * kPhotoWidth + kPhotoWidth / 2);
  ASSERT_EQ(case_mask(cases[0], c.views[2], c.maps[2])[middle], 1);
  c.maps[2].zdepth[middle] = float(0.3 * (view.cam_from_world * Vec3d{}).z);
  EXPECT_EQ(case_mask(cases[0], c.views[2], c.maps[2])[middle], 0);
  c.maps[2].trusted[middle] = 0;
  EXPECT_EQ(case_mask(cases[0], c.views[2], c.maps[2])[middle], 1);
}

TEST(DisplayCases, CratesAndTablesAreNone) {
  FloorCapture crate;
  Box whole = box_on_the_floor().box;
  whole.low.z = -0.3;
  stand(crate, whole);
  EXPECT_TRUE(display_cases(std::vector{box_on_the_floor()}, crate.views, crate.maps).empty());
  FloorCapture table;  // only its top is opaque
  Box top = whole;
  top.low.z = 0.09;
  stand(table, top);
  EXPECT_TRUE(display_cases(std::vector{box_on_the_floor()}, table.views, table.maps).empty());
  StandingBox unseen = box_on_the_floor();  // behind all cameras: nobody can tell
  unseen.box.low = {40, 40, -0.2}, unseen.box.high = {41, 41, 0.1};
  EXPECT_TRUE(display_cases(std::vector{unseen}, FloorCapture{}.views, FloorCapture{}.maps).empty());
  FloorCapture air;
  StandingBox faint = box_on_the_floor();
  faint.rim = 3;
  EXPECT_TRUE(display_cases(std::vector{faint}, air.views, air.maps).empty());
}

TEST(Proposed, AnOpaqueSceneGetsNoMaskAndTheSameBytesEveryTime) {
  TemporaryFolder folder;
  testing::write_tiny_sfm(folder.path(), 10, 64, 48);
  MasksConfig config;
  std::string first;
  for (int threads : {1, 3}) {
    set_thread_limit(threads);
    test::RecordingContext context({{"sfm", folder.path()}});
    run_masks(config, context);
    set_thread_limit(0);
    EXPECT_FALSE(fs::exists(context.output() / "masks/specular"));
    EXPECT_FALSE(fs::exists(context.output() / "masks/transparent"));
    const std::string report = read_file(context.output() / "masks/report.json");
    EXPECT_NE(report.find("\"proposed\""), std::string::npos);
    EXPECT_NE(report.find("\"unsure\": false"), std::string::npos) << "nothing was looked at";
    if (first.empty())
      first = report;
    else
      EXPECT_EQ(first, report);
  }
}

}  // namespace
}  // namespace vitrine
