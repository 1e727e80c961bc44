// Proposals: what the views disagree about is found where it is, and an opaque scene is left alone.
#include <gtest/gtest.h>

#include "core/camera/json_file.h"
#include "stages/masks/masks.h"
#include "tests/stages/optimize/tiny_capture.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

constexpr int kPhotoWidth = 64, kPhotoHeight = 48;

// Cameras around a floor at z = -0.3, seen exactly by a fit; nothing else.
struct FloorCapture {
  MaskCapture capture;
  std::vector<SmallPhoto> photos;
  QuickFit fit;

  explicit FloorCapture(int views = 16) {
    capture.set.views = testing::ring_of_views(views, kPhotoWidth, kPhotoHeight);
    for (int x = -8; x <= 8; ++x)
      for (int y = -8; y <= 8; ++y)
        for (double z : {-0.3, 0.3})
          capture.set.points.push_back({.position = {0.08 * x, 0.08 * y, z}, .linear_rgb = {}, .views = {0}});
    for (View& view : capture.set.views) {
      view.gain = {1, 1, 1};
      photos.push_back({view, std::vector<float>(3 * kPhotoWidth * kPhotoHeight, 0.4f)});
      FittedView seen{.srgb = photos.back().srgb, .zdepth = std::vector<float>(kPhotoWidth * kPhotoHeight, 0.f)};
      const Rigid world_from_cam = inverse(view.cam_from_world);
      for (int y = 0; y < kPhotoHeight; ++y)
        for (int x = 0; x < kPhotoWidth; ++x) {
          const Vec3d d = world_from_cam.rotation * view.intrinsics.ray(x + 0.5, y + 0.5);
          const double z = (-0.3 - world_from_cam.translation.z) / d.z;
          if (z > 0 && z < 4) seen.zdepth[size_t(y * kPhotoWidth + x)] = float(z);
        }
      fit.views.push_back(std::move(seen));
    }
  }

  // Whether the ball at (0.1, 0, 0) stands in the way.
  static bool ball_at(const View& view, int x, int y) {
    const Vec3d ray = normalized(view.intrinsics.ray(x + 0.5, y + 0.5)), centre = view.cam_from_world * Vec3d{0.1, 0, 0};
    return length(centre - dot(centre, ray) * ray) < 0.2;
  }
};

TEST(ViewDependence, IsZeroWhereAllViewsAgreeAndThereWhereOneDiffers) {
  FloorCapture c;
  // All photos are brighter than the fit by the same amount: its fault, not a reflection. One has a glint.
  for (SmallPhoto& p : c.photos)
    for (float& v : p.srgb) v += 0.05f;
  const Intrinsics& k = c.photos[3].view.intrinsics;
  const Vec3d at = c.photos[3].view.cam_from_world * Vec3d{0, 0, -0.3};
  const int gx = int(k.fx * at.x / at.z + k.cx), gy = int(k.fy * at.y / at.z + k.cy);
  for (int y = gy - 6; y <= gy + 6; ++y)
    for (int x = gx - 6; x <= gx + 6; ++x)
      for (size_t ch = 0; ch < 3; ++ch) c.photos[3].srgb[ch * kPhotoWidth * kPhotoHeight + size_t(y * kPhotoWidth + x)] += 0.3f;
  const auto maps = view_dependence(c.photos, c.fit);
  const size_t glint = size_t(gy * kPhotoWidth + gx);
  EXPECT_GT(maps[3].value[glint], 0.05f);
  for (size_t v : {0u, 7u})
    for (float d : maps[v].value) EXPECT_FALSE(d >= 0.01f) << d;  // NaN: nobody can say
}

TEST(HullVote, FindsTheBallThatEveryViewDisagreesAboutAndSeesThroughIt) {
  FloorCapture c;
  std::vector<DeviationMap> maps;
  for (const SmallPhoto& p : c.photos) {
    DeviationMap map{kPhotoWidth, kPhotoHeight, std::vector<float>(kPhotoWidth * kPhotoHeight, 0.004f)};
    for (int y = 0; y < kPhotoHeight; ++y)
      for (int x = 0; x < kPhotoWidth; ++x)
        if (FloorCapture::ball_at(p.view, x, y)) map.value[size_t(y * kPhotoWidth + x)] = 0.05f;
    maps.push_back(std::move(map));
  }
  HullVoteConfig config;
  config.grid = 48;
  const HullVote vote = hull_vote(config, c.capture, c.photos, c.fit, maps);
  ASSERT_EQ(vote.things.size(), 1u);
  EXPECT_NEAR(vote.things[0].centre.x, 0.1, 0.05);
  EXPECT_NEAR(vote.things[0].centre.z, 0.0, 0.05);
  EXPECT_TRUE(vote.things[0].transparent) << "the floor is seen behind it: " << vote.things[0].see_through;
  size_t both = 0, any = 0;
  for (size_t v = 0; v < c.photos.size(); ++v) {
    const std::vector<int> things = projected_things(vote, c.photos[v], c.fit.views[v]);
    for (int y = 0; y < kPhotoHeight; ++y)
      for (int x = 0; x < kPhotoWidth; ++x) {
        const bool truth = FloorCapture::ball_at(c.photos[v].view, x, y), found = things[size_t(y * kPhotoWidth + x)] >= 0;
        both += truth && found;
        any += truth || found;
      }
  }
  EXPECT_GT(double(both) / double(any), 0.7);

  // The same ball where the fit has a surface in its middle is not seen through.
  for (size_t v = 0; v < c.photos.size(); ++v)
    for (int y = 0; y < kPhotoHeight; ++y)
      for (int x = 0; x < kPhotoWidth; ++x)
        if (FloorCapture::ball_at(c.photos[v].view, x, y))
          c.fit.views[v].zdepth[size_t(y * kPhotoWidth + x)] = float((c.photos[v].view.cam_from_world * Vec3d{0.1, 0, 0}).z);
  const HullVote metal = hull_vote(config, c.capture, c.photos, c.fit, maps);
  ASSERT_EQ(metal.things.size(), 1u);
  EXPECT_FALSE(metal.things[0].transparent) << metal.things[0].see_through;
}

TEST(HullVote, AProposalNeedsManyViewsAndAGoodFit) {
  FloorCapture c;
  std::vector<DeviationMap> maps(c.photos.size(),
                                 {kPhotoWidth, kPhotoHeight, std::vector<float>(kPhotoWidth * kPhotoHeight, 0.03f)});
  const HullVote everywhere = hull_vote({}, c.capture, c.photos, c.fit, maps);
  EXPECT_TRUE(everywhere.unsure) << "views that disagree about everything come from a bad fit";
  EXPECT_TRUE(everywhere.things.empty());
  for (DeviationMap& m : maps) std::fill(m.value.begin(), m.value.end(), NAN);
  EXPECT_TRUE(hull_vote({}, c.capture, c.photos, c.fit, maps).unsure);
}

// A box on the floor, 0.3 wide, seen exactly: opaque, or as if it were not there; in it stands a smaller one.
StandingBox box_on_the_floor() {
  StandingBox standing{
      {.axes = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, .low = {-0.15, -0.15, -0.2}, .high = {0.15, 0.15, 0.1}}, 40, 10};
  return standing;
}
void stand(FloorCapture& c, const Box& box) {
  for (size_t v = 0; v < c.photos.size(); ++v) {
    const View& view = c.photos[v].view;
    for (int y = 0; y < kPhotoHeight; ++y)
      for (int x = 0; x < kPhotoWidth; ++x) {
        const Vec3d ray = transposed_times(view.cam_from_world.rotation, view.intrinsics.ray(x + 0.5, y + 0.5));
        if (const auto crossing = box.crossing(view.centre_in_world(), ray))
          c.fit.views[v].zdepth[size_t(y * kPhotoWidth + x)] = float(crossing->in);
      }
  }
}

TEST(DisplayCases, AreSeenThroughFromAllSidesAndStandOnWhatIsBelow) {
  FloorCapture c;
  Box figure = box_on_the_floor().box;
  figure.low = {-0.05, -0.05, -0.3}, figure.high = {0.05, 0.05, 0};
  stand(c, figure);
  const std::vector<StandingBox> boxes{box_on_the_floor(), box_on_the_floor()};  // found twice
  const auto cases = display_cases({}, boxes, c.photos, c.fit);
  ASSERT_EQ(cases.size(), 1u);
  EXPECT_NEAR(cases[0].box.low.z, -0.3, 0.01) << "its edges began to show a third of its height above the floor";
  EXPECT_GT(cases[0].seen_through, 0.95);
  // Something stands before it in one photo.
  const View& view = c.photos[2].view;
  const size_t middle = size_t(kPhotoHeight / 2 * kPhotoWidth + kPhotoWidth / 2);
  ASSERT_EQ(case_mask(cases[0], c.photos[2], c.fit.views[2])[middle], 1);
  c.fit.views[2].zdepth[middle] = float(0.3 * (view.cam_from_world * Vec3d{}).z);
  EXPECT_EQ(case_mask(cases[0], c.photos[2], c.fit.views[2])[middle], 0);
}

TEST(DisplayCases, CratesAndTablesAreNone) {
  FloorCapture crate;
  Box whole = box_on_the_floor().box;
  whole.low.z = -0.3;
  stand(crate, whole);
  EXPECT_TRUE(display_cases({}, std::vector{box_on_the_floor()}, crate.photos, crate.fit).empty());
  FloorCapture table;  // only its top is opaque
  Box top = whole;
  top.low.z = 0.09;
  stand(table, top);
  EXPECT_TRUE(display_cases({}, std::vector{box_on_the_floor()}, table.photos, table.fit).empty());
  StandingBox unseen = box_on_the_floor();  // behind all cameras: nobody can tell
  unseen.box.low = {40, 40, -0.2}, unseen.box.high = {41, 41, 0.1};
  EXPECT_TRUE(display_cases({}, std::vector{unseen}, FloorCapture{}.photos, FloorCapture{}.fit).empty());
  FloorCapture air;
  StandingBox faint = box_on_the_floor();
  faint.rim = 3;
  EXPECT_TRUE(display_cases({}, std::vector{faint}, air.photos, air.fit).empty());
}

TEST(Proposed, AnOpaqueSceneGetsNoMaskAndTheSameBytesEveryTime) {
  TemporaryFolder folder;
  testing::write_tiny_sfm(folder.path(), 10, 64, 48);
  MasksConfig config;
  config.proposed.fit.steps = 120;
  config.proposed.fit.surfels = 1500;
  config.proposed.vote.grid = 40;
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
    if (first.empty())
      first = report;
    else
      EXPECT_EQ(first, report);
  }
}

}  // namespace
}  // namespace vitrine
