// Equirectangular pictures: every pixel against a pinhole picture that looks there, from the middle of a ball of surfels.
#include "core/render/picture/panorama_picture.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/scene/camera/equirect.h"
#include "core/scene/camera/projection.h"
#include "core/scene/image/resample.h"
#include "stages/render/render.h"
#include "tests/support/error_of.h"
#include "tests/support/recording_context.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

using test::RecordingContext;
using test::TinyCapture;

constexpr int kPanoramaWidth = 96;

std::map<std::string, fs::path> scene_inputs(const TinyCapture& capture) {
  return {{"sfm", capture.sfm()}, {"optimize", capture.optimize()}};
}

// Off the middle of the ball, so that distances differ.
View inside_the_ball() {
  View v;
  v.cam_from_world = test::looking_at({0.05, -0.1, 0.02}, {0.3, 0.4, 0.12});
  v.intrinsics = {64, 64, 40, 40, 32, 32};
  return v;
}

TEST(EquirectGeometry, PixelsAndDirectionsAreInverse) {
  for (const auto& [x, y] : {std::pair{0.5, 0.5}, std::pair{63.5, 20.0}, std::pair{32.0, 16.0}, std::pair{10.25, 31.5}}) {
    const Vec2d back = equirect_pixel(3.0 * equirect_direction(x, y, 64, 32), 64, 32);
    EXPECT_NEAR(back.x, x, 1e-9);
    EXPECT_NEAR(back.y, y, 1e-9);
  }
  EXPECT_LT(length(equirect_direction(32, 16, 64, 32) - Vec3d{0, 0, 1}), 1e-12);
  EXPECT_LT(length(equirect_direction(48, 16, 64, 32) - Vec3d{1, 0, 0}), 1e-12);
  EXPECT_GT(equirect_direction(32, 31, 64, 32).y, 0.9);
}

TEST(PanoramaPicture, EveryPixelIsThatOfAPinholePictureThatLooksThere) {
  const TinyCapture capture;
  ScenePainter painter(read_trained_scene(capture.optimize()), {.layers = true});
  const View panorama = upright_panorama(inside_the_ball());
  const ViewPicture round = panorama_picture(painter, panorama, kPanoramaWidth);
  ASSERT_EQ(round.srgb.width(), kPanoramaWidth);
  ASSERT_EQ(round.srgb.height(), kPanoramaWidth / 2);
  EXPECT_NE(round.layer("depth"), nullptr);
  // Rows of +z: the top of the picture is the blue end of the ball.
  EXPECT_GT(round.linear.at(0, 0, 2), round.linear.at(0, kPanoramaWidth / 2 - 1, 2) + 0.3);
  std::vector<uint8_t> looked_at(round.linear.pixel_count());
  // Cameras that are aligned with no face of the cube, up, down and all around.
  for (int i = 0; i < 12; ++i) {
    const double azimuth = 0.7 + i * 2.4, height = -0.95 + i * 0.17;
    View v;
    const Vec3d centre = panorama.centre_in_world();
    v.cam_from_world = test::looking_at(centre, centre + Vec3d{std::cos(azimuth), std::sin(azimuth), std::tan(1.3 * height)});
    v.intrinsics = {80, 80, 36, 36, 40, 40};
    const ViewPicture flat = painter.picture(v);
    for (int y = 0; y < round.linear.height(); ++y)
      for (int x = 0; x < round.linear.width(); ++x) {
        const Vec3d in_world = transposed_times(panorama.cam_from_world.rotation,
                                                equirect_direction(x + 0.5, y + 0.5, kPanoramaWidth, kPanoramaWidth / 2));
        const auto p = image_point(v.cam_from_world.rotation * in_world, v.intrinsics, 0, 1);
        if (!p) continue;
        looked_at[size_t(y * kPanoramaWidth + x)] = 1;
        float rgb[3];
        sample_bilinear(flat.linear, p->x, p->y, rgb);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(round.linear.at(x, y, c), rgb[c], 0.02) << x << ", " << y;
        float normal[3];  // bilinear: neighbouring surfels of the ball differ by some degrees
        sample_bilinear(flat.normal_in_world, p->x, p->y, normal);
        const float* n = round.normal_in_world.pixel(x, y);
        ASSERT_NEAR(std::hypot(n[0], n[1], n[2]), 1, 1e-5);
        for (int c = 0; c < 3; ++c) ASSERT_NEAR(n[c], normal[c], 0.1) << x << ", " << y;
        // Of the ball's inside: |centre + t d| = radius.
        const double b = dot(centre, in_world), t = -b + std::sqrt(b * b - dot(centre, centre) + 0.4 * 0.4);
        ASSERT_NEAR(round.zdepth.at(x, y), t, 0.03) << x << ", " << y;
      }
  }
  EXPECT_EQ(std::count(looked_at.begin(), looked_at.end(), 0), 0);
}

TEST(PanoramaPicture, LooksWhereItsCameraLooksAndIsUpright) {
  const View v = inside_the_ball(), up = upright_panorama(v);
  EXPECT_LT(length(up.centre_in_world() - v.centre_in_world()), 1e-12);
  EXPECT_LT(length(transposed_times(up.cam_from_world.rotation, Vec3d{0, 1, 0}) - Vec3d{0, 0, -1}), 1e-12);
  const Vec3d was = v.ray(32, 32), is = transposed_times(up.cam_from_world.rotation, Vec3d{0, 0, 1});
  EXPECT_GT(dot(normalized(Vec3d{was.x, was.y, 0}), is), 1 - 1e-9);
  EXPECT_EQ(panorama_width({64, 48, 70, 70, 32, 24}), 440);  // 2 pi 70 = 439.8
}

TEST(RenderStage, PanoramasOfTheCamerasAreTheSameForAnyNumberOfThreads) {
  const TinyCapture capture;
  const RenderConfig config{.camera = RenderCamera::Equirect, .layers = true, .width = 64, .height = 32};
  std::map<std::string, std::string> one, many;
  for (auto* files : {&one, &many}) {
    set_thread_limit(files == &one ? 1 : 4);
    RecordingContext context(scene_inputs(capture));
    run_render(config, context);
    for (const auto& e : fs::recursive_directory_iterator(context.output()))
      if (e.is_regular_file()) (*files)[e.path().lexically_relative(context.output()).string()] = read_file(e.path());
  }
  set_thread_limit(0);
  EXPECT_EQ(one, many);
  ASSERT_TRUE(one.contains("render/view_0.png"));
  EXPECT_TRUE(one.contains("render/layers/depth/view_0.exr"));
  EXPECT_NE(one["render/transforms.json"].find("EQUIRECTANGULAR"), std::string::npos);
}

TEST(RenderStage, ViewsOfOnePlaceAreOnePanorama) {
  const TinyCapture capture;
  ColmapModel model = read_colmap_model(capture.sfm() / "sparse/0");
  for (size_t i = 1; i < 4; ++i) {
    const Vec3d centre = inverse(model.images[0].cam_from_world()).translation;
    model.images[i].translation = -(model.images[i].cam_from_world().rotation * centre);
  }
  write_colmap_model(capture.sfm() / "sparse/0", model, ColmapFormat::Binary);
  RecordingContext context(scene_inputs(capture));
  run_render({.views = ViewChoice::All, .camera = RenderCamera::Equirect, .width = 32, .height = 16}, context);
  EXPECT_EQ(context.metrics.at("views"), 5);
  EXPECT_EQ(read_srgb(context.output() / "render/view_0.png").width(), 32);
}

}  // namespace
}  // namespace vitrine
