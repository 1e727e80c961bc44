// Panoramas of a room through ingest and sfm with the real COLMAP, against their true poses.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <set>

#include "core/scene/camera/holdout.h"
#include "core/scene/camera/panorama_views.h"
#include "core/scene/camera/view_set.h"
#include "stages/ingest/ingest.h"
#include "stages/sfm/sfm.h"
#include "tests/captures/studio.h"
#include "tests/support/pose_errors.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_photos.h"

namespace vitrine {
namespace {

using test::RecordingContext, test::Studio;

constexpr size_t kPanoramas = 4;
constexpr int kPanoramaWidth = 800;

Rigid panorama_pose(size_t i) {
  const double a = 2 * std::numbers::pi * double(i) / kPanoramas, b = a + 0.7 * double(i);
  const Vec3d eye{0.9 * std::cos(a), 0.9 * std::sin(a), 0.9 + 0.15 * double(i % 2)};
  return generate::looking_at(eye, eye + Vec3d{std::cos(b), std::sin(b), 0.0}, {0, 0, 1});
}

TEST(PanoramaCaptures, HaveTheirTruePosesAndOneCentreForAllViewsOfEach) {
  const TemporaryFolder folder;
  const Studio studio({});
  std::vector<View> truth;
  for (size_t i = 0; i < kPanoramas; ++i) {
    const fs::path photo = folder.path() / fmt::format("p{}.jpg", i);
    write_ldr(photo, srgb8_from_linear(studio.panorama(panorama_pose(i), kPanoramaWidth)), 95);
    test::add_exif(photo, std::string("http://ns.adobe.com/xap/1.0/\0", 29) +
                              "<x:xmpmeta><rdf:Description xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\" "
                              "GPano:ProjectionType=\"equirectangular\"/></x:xmpmeta>");
    for (int v = 0; v < kPanoramaViews; ++v)
      truth.push_back({.name = fmt::format("p{}/view_{:02}.jpg", i, v),
                       .cam_from_world = Rigid{panorama_view_rotation(v), {}} * panorama_pose(i)});
  }
  RecordingContext ingested({{"photos", folder.path()}});
  ingest_stage().run(ingested);
  RecordingContext context({{"ingest", ingested.output()}});
  sfm_stage().run(context);

  const std::vector<View> views = load_view_set(context.output()).views;
  EXPECT_EQ(views.size(), kPanoramas * kPanoramaViews) << "views without matches have the pose of their panorama";
  EXPECT_EQ(context.metrics.at("panoramas"), double(kPanoramas));
  const std::vector<uint8_t> heldout = heldout_views(context.output(), views, 3);
  for (size_t i = 0; i < views.size(); ++i) EXPECT_EQ(heldout[i] != 0, i / kPanoramaViews % 3 == 0) << views[i].name;
  std::vector<Vec3d> got, expected;
  for (size_t i = 0; i < views.size(); ++i) {
    EXPECT_EQ(views[i].name, truth[i].name);
    EXPECT_LT(length(views[i].centre_in_world() - views[i - i % kPanoramaViews].centre_in_world()), 1e-9) << views[i].name;
    EXPECT_NEAR(views[i].intrinsics.fx, 0.5 * views[i].intrinsics.width, 1e-9) << "the lens is known";
    got.push_back(views[i].centre_in_world()), expected.push_back(truth[i].centre_in_world());
  }
  const Similarity to_truth = test::aligned(got, expected);
  double worst_m = 0, worst_deg = 0;
  for (size_t i = 0; i < views.size(); ++i) {
    worst_m = std::max(worst_m, length(to_truth * got[i] - expected[i]));
    const Mat3d off =
        views[i].cam_from_world.rotation * transposed(to_truth.rotation) * transposed(truth[i].cam_from_world.rotation);
    worst_deg =
        std::max(worst_deg, std::acos(std::min(1.0, 0.5 * (off(0, 0) + off(1, 1) + off(2, 2) - 1))) * 180 / std::numbers::pi);
  }
  std::cout << "worst centre off by " << 1000 * worst_m << " mm in a room of 4 m, worst rotation by " << worst_deg
            << " degrees\n";
  EXPECT_LT(worst_m, 0.001);
  EXPECT_LT(worst_deg, 0.05);
}

}  // namespace
}  // namespace vitrine
