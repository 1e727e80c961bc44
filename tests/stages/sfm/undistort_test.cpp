// Undistortion against pictures whose every pixel is a known function of the viewing direction.
#include "stages/sfm/outputs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/foundation/base/error.h"
#include "tests/core/intake/poses/synthetic_model.h"

namespace vitrine {
namespace {

const ColmapCamera kLenses[] = {
    {1, 2, 160, 120, {150, 82.5, 58.25, 0.08}},                       // SIMPLE_RADIAL, pincushion
    {2, 2, 160, 120, {150, 82.5, 58.25, -0.12}},                      // barrel
    {3, 3, 160, 120, {150, 80, 60, -0.2, 0.05}},                      // RADIAL
    {4, 4, 161, 119, {150, 152, 79, 61, -0.1, 0.02, 0.003, -0.002}},  // OPENCV
};

void pattern(double u, double v, float* rgb) {
  rgb[0] = float(0.5 + 0.4 * std::sin(9 * u + 3 * v));
  rgb[1] = float(0.5 + 0.4 * std::cos(7 * v - 2 * u));
  rgb[2] = float(0.5 + 0.2 * u + 0.3 * v);
}

TEST(Undistortion, GivesThePictureThatAPinholeCameraSees) {
  double worst = 0;
  for (const ColmapCamera& camera : kLenses) {
    ImageF photo(int(camera.width), int(camera.height), 3);
    for (int y = 0; y < photo.height(); ++y)
      for (int x = 0; x < photo.width(); ++x) {
        const std::optional<Vec2d> d = unproject(camera, {x + 0.5, y + 0.5});
        ASSERT_TRUE(d.has_value());
        pattern(d->x, d->y, photo.pixel(x, y));
      }
    const Undistortion u = undistortion(camera);
    EXPECT_FALSE(u.identity);
    const ImageF straight = undistorted(photo, u);
    ASSERT_EQ(straight.width(), u.target.width);
    for (int y = 2; y < straight.height() - 2; ++y)
      for (int x = 2; x < straight.width() - 2; ++x) {
        float expected[3];
        const Vec3d ray = u.target.ray(x + 0.5, y + 0.5);
        pattern(ray.x, ray.y, expected);
        for (int c = 0; c < 3; ++c) worst = std::max(worst, double(std::abs(expected[c] - straight.at(x, y, c))));
      }
  }
  EXPECT_LT(worst, 1.5e-3);  // worst seen 7e-4: Catmull-Rom at 0.06 radians of phase a pixel
}

TEST(Undistortion, LeavesNoBlackBorderAndWastesLittle) {
  for (const ColmapCamera& camera : kLenses) {
    const Undistortion u = undistortion(camera);
    const double w = double(camera.width), h = double(camera.height);
    double reach = 1e9;  // how near the frame comes to the photo's border
    const auto check = [&](double x, double y) {
      const Vec3d ray = u.target.ray(x, y);
      const Vec2d p = project(camera, {ray.x, ray.y});
      EXPECT_GE(std::min({p.x, p.y, w - p.x, h - p.y}), -1e-9) << "camera " << camera.id;
      reach = std::min({reach, p.x, p.y, w - p.x, h - p.y});
    };
    for (int i = 0; i <= u.target.width; ++i) check(i, 0), check(i, u.target.height);
    for (int i = 0; i <= u.target.height; ++i) check(0, i), check(u.target.width, i);
    EXPECT_LT(reach, 1.0);
    // The principal point moved with the crop, by whole pixels.
    const Intrinsics before = pinhole_part(camera);
    EXPECT_EQ(before.fx, u.target.fx);
    EXPECT_EQ(before.cx - u.target.cx, std::round(before.cx - u.target.cx));
    EXPECT_EQ(before.cy - u.target.cy, std::round(before.cy - u.target.cy));
  }
}

TEST(Undistortion, OfFisheyePhotosLeavesWhatAPinholeCameraSeesUpTo50Degrees) {
  const double kReach = std::tan(50.3 / 57.29578);
  for (const auto& [camera, limited] :
       {std::pair{ColmapCamera{1, 5, 400, 300, {260, 262, 203, 149, 0.03, -0.01, 0.002, 0}}, false},
        {ColmapCamera{2, 7, 400, 300, {260, 262, 203, 149, 0.9}}, false},
        {ColmapCamera{3, 10, 400, 300, {260, 262, 203, 149, 0.03, 0, 2e-3, 1e-3, 0, 0, 1e-3, 0}}, false},
        {ColmapCamera{4, 8, 400, 400, {120, 200, 200, 0.01}}, true}}) {  // 190 degrees
    ImageF photo(int(camera.width), int(camera.height), 3, 0.f);
    for (int y = 0; y < photo.height(); ++y)
      for (int x = 0; x < photo.width(); ++x)
        if (const std::optional<Vec2d> d = unproject(camera, {x + 0.5, y + 0.5})) pattern(d->x, d->y, photo.pixel(x, y));
    const Undistortion u = undistortion(camera);
    EXPECT_FALSE(u.identity);
    const ImageF straight = undistorted(photo, u);
    double worst = 0, widest = 0;
    for (int y = 2; y < straight.height() - 2; ++y)
      for (int x = 2; x < straight.width() - 2; ++x) {
        float expected[3];
        const Vec3d ray = u.target.ray(x + 0.5, y + 0.5);
        widest = std::max({widest, std::abs(ray.x), std::abs(ray.y)});
        pattern(ray.x, ray.y, expected);
        for (int c = 0; c < 3; ++c) worst = std::max(worst, double(std::abs(expected[c] - straight.at(x, y, c))));
      }
    EXPECT_LT(worst, limited ? 0.02 : 4e-3) << camera.id;  // the wide lens has half as many pixels a radian
    EXPECT_LT(widest, kReach) << camera.id;
    if (limited) EXPECT_GT(widest, 1.15) << "a lens of 190 degrees reaches the limit";
  }
}

TEST(Undistortion, CopiesWhenTheLensIsStraight) {
  EXPECT_TRUE(undistortion({1, 1, 640, 480, {600, 600, 320, 240}}).identity);
  EXPECT_TRUE(undistortion({1, 2, 640, 480, {600, 320, 240, 1e-6}}).identity);
  const Undistortion u = undistortion({1, 2, 640, 480, {600, 320, 240, 1e-3}});
  EXPECT_FALSE(u.identity);
}

TEST(Undistortion, RefusesALensThatFoldsOver) {
  try {
    undistortion({1, 2, 640, 480, {400, 320, 240, -0.9}});
    FAIL() << "accepted";
  } catch (const Error& e) {
    EXPECT_EQ(e.detail().code, "SFM_BAD_DISTORTION");
  }
}

TEST(Undistortion, MovesObservationsToWhereThePinholeCameraSeesTheirPoints) {
  for (const ColmapCamera& camera : kLenses) {
    const ColmapModel model = synthetic_model(ring(8, 2, 1, {0, 0, 1}), cloud(300, 5, 0.4), camera);
    ASSERT_GT(model.points.size(), 100u);
    ColmapModel straight = undistorted(model, {undistortion(camera)});
    check_colmap_model(straight, "test");
    EXPECT_EQ(straight.points.size(), model.points.size());
    EXPECT_EQ(straight.cameras[0].model_id, 1);
    size_t seen = 0;
    for (const ColmapPoint3D& p : straight.points)
      for (const ColmapTrackElement& t : p.track) {
        const ColmapImage& image = *straight.find_image(t.image_id);
        const Vec3d q = image.cam_from_world() * p.position;
        const Vec2d pixel = project(straight.cameras[0], {q.x / q.z, q.y / q.z});
        EXPECT_NEAR(pixel.x, image.points[t.point2d_index].x, 1e-6);
        EXPECT_NEAR(pixel.y, image.points[t.point2d_index].y, 1e-6);
        ++seen;
      }
    EXPECT_GT(seen, 500u);
    for (const ColmapImage& image : straight.images)
      for (const ColmapPoint2D& p : image.points) EXPECT_NE(p.point3d_id, kNoPoint3D);
  }
}

}  // namespace
}  // namespace vitrine
