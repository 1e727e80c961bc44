#include "core/scene/camera/panorama_views.h"

#include <gtest/gtest.h>

#include "tests/support/sphere_picture.h"

namespace vitrine {
namespace {

TEST(PanoramaViews, ShowWhatPinholePhotosOfTheSurroundingsShow) {
  const ImageF panorama = test::sphere_panorama(512);
  const EquirectSampler sampler(panorama);
  const Intrinsics k = panorama_view_intrinsics(512, 0);
  EXPECT_EQ(k.width, 163);
  EXPECT_EQ(k.fx, 81.5);
  for (int view : {0, 3, 7}) {
    const Mat3d rotation = panorama_view_rotation(view);
    const ImageF seen = panorama_view(sampler, 3, k, rotation), expected = test::sphere_photo(k, rotation);
    double worst = 0;
    for (size_t i = 0; i < seen.data().size(); ++i)
      worst = std::max(worst, double(std::abs(seen.data()[i] - expected.data()[i])));
    EXPECT_LT(worst, 0.02) << view;
  }
}

TEST(PanoramaViews, AreTwoRingsThatCoverTheSphereUpToEightyDegrees) {
  for (int v = 0; v < kPanoramaViews; ++v) {
    const Mat3d r = panorama_view_rotation(v);
    const Vec3d right = transposed_times(r, Vec3d{1, 0, 0}), forward = transposed_times(r, Vec3d{0, 0, 1});
    EXPECT_NEAR(right.y, 0, 1e-12);                                                       // level
    EXPECT_NEAR(std::asin(-forward.y) * 180 / std::numbers::pi, v < 5 ? 35 : -35, 1e-9);  // y is down
    EXPECT_LT(length(cross(transposed_times(r, Vec3d{1, 0, 0}), transposed_times(r, Vec3d{0, 1, 0})) - forward), 1e-12);
  }
  for (double lat_deg = -79.5; lat_deg < 80; lat_deg += 3)
    for (double lon_deg = 0; lon_deg < 360; lon_deg += 3) {
      const double lat = lat_deg * std::numbers::pi / 180, lon = lon_deg * std::numbers::pi / 180;
      const Vec3d d{std::cos(lat) * std::sin(lon), std::sin(lat), std::cos(lat) * std::cos(lon)};
      bool seen = false;
      for (int v = 0; v < kPanoramaViews; ++v) {
        const Vec3d p = panorama_view_rotation(v) * d;
        seen |= p.z > 0 && std::abs(p.x) <= p.z && std::abs(p.y) <= p.z;
      }
      EXPECT_TRUE(seen || std::abs(lat_deg) > 70) << lat_deg << " " << lon_deg;
    }
}

TEST(PanoramaViews, AreLimitedAndThePanoramaIsReducedWithThem) {
  const Intrinsics k = panorama_view_intrinsics(8192, 160);
  EXPECT_EQ(k.width, 160);
  EXPECT_EQ(k.fx, 80);
  EXPECT_EQ(panorama_for_views(ImageF(1024, 512, 3), k).width(), 502);
  EXPECT_EQ(panorama_for_views(ImageF(400, 200, 3), k).width(), 400);
}

}  // namespace
}  // namespace vitrine
