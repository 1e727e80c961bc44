// Views of fisheye lenses: together they show what the lens shows, and each is the picture of a pinhole camera.
#include "core/scene/camera/wide_views.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/scene/camera/colmap_lens.h"
#include "core/scene/camera/lens_circle.h"

namespace vitrine {
namespace {

constexpr double kOneDegree = std::numbers::pi / 180;

ColmapCamera lens(const char* model, int width, int height, std::vector<double> params) {
  return {1, colmap_camera_type(model)->id, uint64_t(width), uint64_t(height), std::move(params)};
}

struct Wide {
  ColmapCamera camera;
  double circle_px;
};
const Wide kWide[] = {{lens("OPENCV_FISHEYE", 200, 200, {63.66, 63.66, 100, 100, 0, 0, 0, 0}), 100},    // 180 degrees
                      {lens("OPENCV_FISHEYE", 260, 200, {60, 61, 133, 97, 0.02, -0.004, 1e-4, 0}), 0},  // fills the sensor
                      {lens("RADIAL_FISHEYE", 240, 240, {60, 120, 120, 0.01, -0.002}), 110},            // 200 degrees and more
                      {lens("SIMPLE_RADIAL_FISHEYE", 320, 180, {110, 160, 90, 0.01}), 0},               // 160 x 90
                      {lens("FOV", 300, 200, {120, 120, 150, 100, 1.2}), 0},
                      {lens("THIN_PRISM_FISHEYE", 200, 200, {64, 63, 99, 101, 0.01, 0, 1e-3, -2e-3, 0, 0, 1e-3, 0}), 95}};

TEST(LensRays, AreTheInverseOfTheirPixelsAlsoBehindTheCamera) {
  for (const Wide& w : kWide)
    for (double angle = 0; angle < 100; angle += 7)
      for (double turn = 0; turn < 6.2; turn += 0.9) {
        if (angle > 90 && w.camera.model_id == colmap_camera_type("OPENCV_FISHEYE")->id && w.circle_px == 0) continue;
        const double a = angle * kOneDegree;
        const Vec3d ray{std::sin(a) * std::cos(turn), std::sin(a) * std::sin(turn), std::cos(a)};
        const std::optional<Vec3d> back = ray_of_pixel(w.camera, project_ray(w.camera, 3.0 * ray));
        ASSERT_TRUE(back) << w.camera.model_id << " " << angle;
        EXPECT_LT(length(normalized(*back) - ray), 1e-9) << w.camera.model_id << " " << angle;
        if (angle > 80) continue;
        const Vec2d pixel = project(w.camera, {ray.x / ray.z, ray.y / ray.z}), same = project_ray(w.camera, ray);
        EXPECT_LT(std::hypot(pixel.x - same.x, pixel.y - same.y), 1e-9);
      }
}

TEST(WideViews, CoverWhatTheLensShowsAndKnowWhatItDoesNot) {
  for (const Wide& w : kWide) {
    const std::vector<Undistortion> views = lens_views(w.camera, w.circle_px);
    ASSERT_GT(views.size(), 1u) << w.camera.model_id;
    const Intrinsics k = pinhole_part(w.camera);
    size_t shown = 0, covered = 0;
    for (int y = 1; y < k.height; y += 2)
      for (int x = 1; x < k.width; x += 2) {
        const Vec2d pixel{x + 0.5, y + 0.5};
        if (w.circle_px > 0 && std::hypot(pixel.x - k.cx, pixel.y - k.cy) > w.circle_px - 1) continue;
        if (!ray_of_pixel(w.camera, pixel)) continue;
        ++shown;
        bool found = false;
        for (const Undistortion& u : views) {
          const std::optional<Vec2d> at = undistorted(pixel, u);
          if (!at || !(at->x >= 0 && at->y >= 0 && at->x < u.target.width && at->y < u.target.height)) continue;
          found = true;
          const std::optional<Vec2d> back = seen_pixel(u, *at);
          ASSERT_TRUE(back) << w.camera.model_id << ": " << pixel.x << " " << pixel.y;
          EXPECT_LT(std::hypot(back->x - pixel.x, back->y - pixel.y), 1e-5);
        }
        covered += found;
      }
    EXPECT_GT(double(covered), 0.99 * double(shown)) << w.camera.model_id;
    for (const Undistortion& u : views) {
      const ImageF unseen = unseen_pixels(u);
      ImageF white(k.width, k.height, 1, 1.f);
      const ImageF cut = undistorted(white, u);
      for (size_t i = 0; i < cut.pixel_count(); ++i)
        ASSERT_NEAR(cut.data()[i] + (unseen.pixel_count() > 0 ? unseen.data()[i] : 0.f), 1, 1e-5) << "black where unseen";
    }
  }
}

TEST(WideViews, OfHalfASphereAreOneWholeFaceAndFourHalves) {
  const std::vector<Undistortion> views = lens_views(kWide[0].camera, kWide[0].circle_px);
  ASSERT_EQ(views.size(), 5u);
  EXPECT_EQ(views[0].rotation->c2, (Vec3d{0, 0, 1})) << "the first looks along the axis";
  EXPECT_NEAR(views[0].target.fx, 63.66, 0.01) << "as many pixels a radian as the photo has at its axis";
  const double whole = views[0].target.width;
  for (size_t v = 1; v < 5; ++v) {
    const Intrinsics& k = views[v].target;
    EXPECT_NEAR(std::max(k.width, k.height), whole, 3);
    EXPECT_NEAR(std::min(k.width, k.height), 0.5 * whole, 5) << "what is behind the camera is cropped";
    EXPECT_NEAR(determinant(*views[v].rotation), 1, 1e-12);
  }
}

TEST(WideViews, ShowWhatAPinholeCameraSees) {
  const Wide& w = kWide[0];
  const auto pattern = [](const Vec3d& d, float* rgb) {
    rgb[0] = float(0.5 + 0.4 * std::sin(4 * d.x + d.y)), rgb[1] = float(0.5 + 0.4 * std::cos(3 * d.y - d.z));
    rgb[2] = float(0.5 + 0.3 * d.z);
  };
  ImageF photo(200, 200, 3, 0.f);
  for (int y = 0; y < 200; ++y)
    for (int x = 0; x < 200; ++x)
      if (const auto ray = ray_of_pixel(w.camera, {x + 0.5, y + 0.5})) pattern(normalized(*ray), photo.pixel(x, y));
  for (const Undistortion& u : lens_views(w.camera, w.circle_px - 2)) {
    const ImageF cut = undistorted(photo, u), unseen = unseen_pixels(u);
    double worst = 0;
    for (int y = 0; y < cut.height(); ++y)
      for (int x = 0; x < cut.width(); ++x) {
        if (unseen.pixel_count() > 0 && unseen.at(x, y) > 0) continue;
        float expected[3];
        pattern(normalized(transposed_times(*u.rotation, u.target.ray(x + 0.5, y + 0.5))), expected);
        for (int c = 0; c < 3; ++c) worst = std::max(worst, double(std::abs(cut.at(x, y, c) - expected[c])));
      }
    EXPECT_LT(worst, 2e-3);
  }
}

TEST(WideViews, NarrowLensesGiveOnePicture) {
  for (const ColmapCamera& camera :
       {lens("OPENCV_FISHEYE", 400, 300, {260, 262, 203, 149, 0.03, -0.01, 0.002, 0}),
        lens("OPENCV", 400, 300, {150, 150, 200, 150, -0.01, 0, 0, 0}), lens("PINHOLE", 400, 300, {90, 90, 200, 150})}) {
    const std::vector<Undistortion> views = lens_views(camera);
    ASSERT_EQ(views.size(), 1u);
    EXPECT_FALSE(views[0].rotation);
  }
  EXPECT_NEAR(widest_field_deg(kWide[0].camera, 100), 180, 0.1);
  EXPECT_NEAR(widest_field_deg(kWide[0].camera, 50), 90, 0.1);
}

TEST(WideViews, LieInAFolderInWhichNoPhotoLies) {
  const std::vector<std::string> stems{"a", "a/b", "c"};
  EXPECT_EQ(view_folders(stems), (std::vector<std::string>{"a_", "a/b", "c"}));
  EXPECT_EQ(view_name("a_", "a.JPG", 3), "a_/view_03.JPG");
}

Image8 disc(int side, double radius, uint8_t inside, uint8_t outside) {
  Image8 photo(side, side, 3, outside);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x)
      if (std::hypot(x + 0.5 - 0.5 * side, y + 0.5 - 0.5 * side) < radius)
        for (int c = 0; c < 3; ++c) photo.at(x, y, c) = uint8_t(inside + (x * 7 + y * 13) % 60);
  return photo;
}

TEST(LensCircle, IsTheEdgeThatAllPhotosHave) {
  LensCircle circle(400, 400, {200, 200});
  circle.add(disc(200, 92, 90, 6));  // a smaller copy
  circle.add(disc(400, 184, 30, 9));
  EXPECT_NEAR(circle.radius(), 182, 2);
}

TEST(LensCircle, PhotosThatFillTheSensorAndDarkOnesHaveNone) {
  for (const auto& [inside, outside, radius] : {std::tuple{90, 60, 180.0}, {90, 5, 40.0}, {90, 5, 400.0}}) {
    LensCircle circle(400, 400, {200, 200});
    circle.add(disc(400, radius, uint8_t(inside), uint8_t(outside)));
    EXPECT_EQ(circle.radius(), 0) << inside << " " << outside << " " << radius;
  }
  LensCircle dark(300, 200, {150, 100}), vignette(300, 200, {150, 100});
  dark.add(Image8(300, 200, 3, uint8_t{8}));
  EXPECT_EQ(dark.radius(), 0);
  Image8 half(300, 200, 3, uint8_t{4});  // a lit window in a dark room
  for (int y = 60; y < 140; ++y)
    for (int x = 20; x < 120; ++x)
      for (int c = 0; c < 3; ++c) half.at(x, y, c) = 200;
  vignette.add(half);
  EXPECT_EQ(vignette.radius(), 0);
}

}  // namespace
}  // namespace vitrine
