#include "core/intake/poses/photo_orientation.h"

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/scene/image/resample.h"

namespace vitrine {
namespace {

constexpr int kWidth = 7, kHeight = 5;

TEST(UprightPixel, GoesWhereIngestPutsThePixel) {
  for (int orientation = 1; orientation <= 8; ++orientation)
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        ImageF stored(kWidth, kHeight, 1);
        stored.at(x, y) = 1;
        const ImageF turned = upright(stored, orientation);
        const Vec2d to = upright_pixel({x + 0.5, y + 0.5}, orientation, {kWidth, kHeight});
        ASSERT_GE(to.x, 0);
        ASSERT_GE(to.y, 0);
        ASSERT_LT(to.x, turned.width());
        ASSERT_LT(to.y, turned.height());
        EXPECT_EQ(turned.at(int(to.x), int(to.y)), 1) << "orientation " << orientation << ", pixel " << x << " " << y;
      }
}

TEST(UprightFromStored, MirrorsForTheOrientationsThatSayIt) {
  for (int orientation = 1; orientation <= 8; ++orientation)
    EXPECT_EQ(determinant(upright_from_stored(orientation)), is_mirrored(orientation) ? -1 : 1) << orientation;
}

// What the stored photo's camera sees of a place, turned as ingest turns the photo, is what the upright camera sees of it.
TEST(UprightCamera, SeesEveryPlaceWhereTheTurnedPhotoShowsIt) {
  const std::vector<ColmapCamera> cameras = {
      {1, colmap_camera_type("SIMPLE_PINHOLE")->id, 640, 480, {600, 330, 225}},
      {1, colmap_camera_type("PINHOLE")->id, 640, 480, {600, 590, 330, 225}},
      {1, colmap_camera_type("SIMPLE_RADIAL")->id, 640, 480, {600, 330, 225, -0.08}},
      {1, colmap_camera_type("RADIAL")->id, 640, 480, {600, 330, 225, -0.08, 0.02}},
      {1, colmap_camera_type("OPENCV")->id, 640, 480, {600, 590, 330, 225, -0.08, 0.02, 0.004, -0.007}},
      {1, colmap_camera_type("FULL_OPENCV")->id, 640, 480, {600, 590, 330, 225, -0.08, 0.02, 0.004, -0.007, 0.01, 0.02, 0, 0}}};
  Rng rng(3);
  for (const ColmapCamera& camera : cameras)
    for (int orientation = 1; orientation <= 8; ++orientation) {
      const Rigid pose{rotation_matrix(normalized(Quatd{rng.normal(), rng.normal(), rng.normal(), rng.normal()})),
                       {rng.normal(), rng.normal(), rng.normal()}};
      const ColmapCamera turned = upright_camera(camera, orientation);
      EXPECT_EQ(turned.width, swaps_sides(orientation) ? 480u : 640u);
      const Rigid turned_pose = upright_pose(pose, orientation);
      EXPECT_NEAR(determinant(turned_pose.rotation), 1, 1e-12);
      for (int i = 0; i < 20; ++i) {
        const Vec3d in_cam{0.4 * rng.normal(), 0.3 * rng.normal(), 1.5 + rng.uniform_double()};
        Vec3d place = inverse(pose) * in_cam;
        const Vec2d stored = project(camera, {in_cam.x / in_cam.z, in_cam.y / in_cam.z});
        const Vec2d expected = upright_pixel(stored, orientation, {640, 480});
        if (is_mirrored(orientation)) place = mirrored_world(place);
        const Vec3d q = turned_pose * place;
        const Vec2d seen = project(turned, {q.x / q.z, q.y / q.z});
        EXPECT_NEAR(seen.x, expected.x, 1e-8) << "orientation " << orientation;
        EXPECT_NEAR(seen.y, expected.y, 1e-8) << "orientation " << orientation;
      }
    }
}

}  // namespace
}  // namespace vitrine
