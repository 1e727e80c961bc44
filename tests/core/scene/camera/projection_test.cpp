// Pixels and depths of points, with the limits near the camera and at the picture's border.
#include <gtest/gtest.h>

#include "core/scene/camera/projection.h"

namespace vitrine {
namespace {

constexpr Intrinsics kCamera{40, 30, 50, 60, 20, 15};

TEST(Projection, InvertsTheRayOfAPixel) {
  View view{.intrinsics = kCamera};
  view.cam_from_world = {rotation_matrix(normalized(Quatd{0.9, 0.2, -0.3, 0.1})), {0.3, -0.2, 0.5}};
  const Vec3d place = inverse(view.cam_from_world) * (2.5 * kCamera.ray(31.25, 4.5));
  for (const auto& p : {projection(place, view), image_point(place, view), image_point(view.cam_from_world * place, kCamera)}) {
    ASSERT_TRUE(p);
    EXPECT_NEAR(p->x, 31.25, 1e-9);
    EXPECT_NEAR(p->y, 4.5, 1e-9);
    EXPECT_NEAR(p->z, 2.5, 1e-12);
  }
}

TEST(Projection, NothingIsSeenAtTheNearLimitOrBehindTheCamera) {
  for (const double z : {0.0, -1.0, 0.25}) EXPECT_FALSE(projection(Vec3d{0, 0, z}, kCamera, 0.25)) << z;
  EXPECT_TRUE(projection(Vec3d{0, 0, 0.2500001}, kCamera, 0.25));
  EXPECT_FALSE(image_point(-kCamera.ray(20, 15), kCamera)) << "the point behind has the same pixel";
  EXPECT_FALSE(image_point(Vec3d{NAN, 0, 1}, kCamera));
  EXPECT_FALSE(image_point(Vec3d{0, 0, NAN}, kCamera));
}

TEST(Projection, ThePictureEndsBeforeItsSizeAndAMarginNarrowsIt) {
  const auto inside = [](double x, double y, double margin) { return in_picture({x, y, 1}, kCamera, margin); };
  EXPECT_TRUE(inside(0, 0, 0) && inside(39.99, 29.99, 0));
  EXPECT_FALSE(inside(40, 10, 0) || inside(10, 30, 0) || inside(-0.01, 10, 0) || inside(10, -0.01, 0));
  EXPECT_TRUE(inside(2, 2, 2) && inside(37.99, 27.99, 2));
  EXPECT_FALSE(inside(38, 10, 2) || inside(10, 28, 2) || inside(1.99, 10, 2) || inside(10, 1.99, 2));
  EXPECT_TRUE(projection(Vec3d{100, 0, 1}, kCamera)) << "outside the picture, in front of the camera";
  EXPECT_FALSE(image_point(Vec3d{100, 0, 1}, kCamera));
}

}  // namespace
}  // namespace vitrine
