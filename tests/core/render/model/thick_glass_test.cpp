// Rays through solid glass against Snell's law in closed form: paths, pictures, gradients.
#include <algorithm>

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "core/render/model/layered_model.h"
#include "tests/core/scene/mesh/shapes.h"
#include "tests/core/render/model/exact_model.h"
#include "tests/core/render/model/snell_ball.h"
#include "tests/core/render/model/tiny_rooms.h"

namespace vitrine {
namespace {

constexpr float kGlassIor = 1.5f;

// Six sides without common vertices, so that the normals are those of the sides. `frame`: columns are the edges.
TriMesh glass_box(const Vec3f& corner, const Mat3f& frame, uint32_t n = 4) {
  TriMesh box;
  const auto side = [&](const Vec3f& from, const Vec3f& u, const Vec3f& v) {  // cross(u, v) looks out
    TriMesh grid = shapes::grid(n);
    for (Vec3f& p : grid.positions) p = from + p.x * u + p.y * v;
    shapes::append(box, grid);
  };
  const Vec3f &x = frame.c0, &y = frame.c1, &z = frame.c2;
  side(corner, y, x);
  side(corner + z, x, y);
  side(corner, z, y);
  side(corner + x, y, z);
  side(corner, x, z);
  side(corner + y, z, x);
  return box;
}

TEST(ThickGlass, ABallBendsRaysAsTheClosedFormSays) {
  const Vec3f centre{0.1f, -0.2f, 0.05f};
  const float radius = 0.6f;
  const ThickGlass ball(shapes::sphere(centre, radius, 150, 300), kGlassIor, 0.01f);
  Rng rng(5);
  double worst_way = 0, worst_place = 0;
  int bent = 0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3d eye = 2.0 * normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()});
    const Vec3d at = cast<double>(centre) + 0.3 * Vec3d{rng.normal(), rng.normal(), rng.normal()};
    const auto exact = test::through_ball(eye, normalized(at - eye), cast<double>(centre), radius, kGlassIor);
    if (!exact || exact->offset > 0.9) continue;  // beside it or near the silhouette, where a polygon is not a ball
    const BentRay ray = ball.path(cast<float>(eye), cast<float>(normalized(at - eye)), float(exact->entry_distance));
    ASSERT_EQ(ray.path, GlassPath::Bent) << i;
    ASSERT_EQ(ray.leg_count, 2u);
    ++bent;
    worst_place = std::max(worst_place, length(cast<double>(ray.legs[1].origin) - exact->exit));
    worst_way = std::max(worst_way, length(cast<double>(ray.legs[1].direction) - exact->direction));
    EXPECT_NEAR(ray.legs[0].length, length(exact->exit - cast<double>(ray.legs[0].origin)), 3e-3);
    EXPECT_EQ(ray.legs[1].length, std::numeric_limits<float>::infinity());
  }
  EXPECT_GT(bent, 500);
  EXPECT_LT(worst_place, 2e-4);  // seen: 9e-5
  EXPECT_LT(worst_way, 5e-4);    // 2.5e-4
}

TEST(ThickGlass, APlateShiftsRaysAndTurnsNone) {
  const double thickness = 0.2;
  const ThickGlass plate(glass_box({-2, -2, 1}, {{4, 0, 0}, {0, 4, 0}, {0, 0, float(thickness)}}), kGlassIor, 0.01f);
  for (const double angle : {0.0, 0.2, 0.5, 0.9}) {
    const Vec3f d{float(std::sin(angle)), 0, float(std::cos(angle))};
    const BentRay ray = plate.path({0, 0.1f, 0}, d, float(1 / std::cos(angle)));
    ASSERT_EQ(ray.path, GlassPath::Bent) << angle;
    ASSERT_EQ(ray.leg_count, 2u);
    EXPECT_LT(length(ray.legs[1].direction - d), 1e-5f);
    // Across the plate tan(angle inside) times the thickness, from where it went in.
    const double inside = std::asin(std::sin(angle) / double(kGlassIor));
    EXPECT_NEAR(ray.legs[1].origin.x, std::tan(angle) + std::tan(inside) * thickness, 1e-5);
    EXPECT_NEAR(ray.legs[1].origin.z, 1 + thickness, 1e-5);
  }
}

TEST(ThickGlass, SaysWhyARayStaysStraight) {
  const TriMesh box = glass_box({-0.5f, -0.5f, 1}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}});
  const ThickGlass cube(box, kGlassIor, 0.02f);
  const Vec3f eye{0.2f, 0.1f, 0}, ahead{0, 0, 1};
  EXPECT_EQ(cube.path(eye, ahead, 1).path, GlassPath::Bent);
  EXPECT_EQ(cube.path(eye, ahead, 1.5f).path, GlassPath::Straight) << "the picture shows another surface";
  EXPECT_EQ(cube.path({2, 2, 0}, ahead, 1).path, GlassPath::Straight) << "beside it";
  EXPECT_EQ(cube.path({0, 0, 1.5f}, ahead, 0.5f).path, GlassPath::Straight) << "the camera is in the glass";
  // A long bar mirrors its rays more often than anyone follows them.
  const ThickGlass bar(glass_box({-0.5f, -0.5f, 1}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 40}}), kGlassIor, 0.02f);
  EXPECT_EQ(bar.path({-0.7f, 0, 0}, normalized(Vec3f{1, 0, 1}), std::sqrt(2.f)).path, GlassPath::TotalReflection);
  EXPECT_EQ(bar.path({-0.7f, 0, 0}, normalized(Vec3f{1, 0, 1}), std::sqrt(2.f)).leg_count, 0u);
  TriMesh open = box;
  std::erase_if(open.faces,
                [&](const auto& f) { return std::ranges::all_of(f, [&](uint32_t v) { return open.positions[v].z > 1.99f; }); });
  EXPECT_EQ(ThickGlass(open, kGlassIor, 0.02f).path(eye, ahead, 1).path, GlassPath::NoExit);
}

TEST(ThickGlass, WhatCannotLeaveIsMirroredInside) {
  const ThickGlass cube(glass_box({-0.5f, -0.5f, 1}, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}), kGlassIor, 0.02f);
  // In at the front at 45 degrees, 62 degrees from the normal of the side; mirrored there it leaves at the back.
  const BentRay ray = cube.path({-0.7f, 0.1f, 0}, normalized(Vec3f{1, 0, 1}), std::sqrt(2.f));
  ASSERT_EQ(ray.path, GlassPath::Bent);
  ASSERT_EQ(ray.leg_count, 3u);
  const double inside = std::asin(std::sqrt(0.5) / double(kGlassIor)), slope = std::tan(inside);
  EXPECT_NEAR(ray.legs[0].origin.x, 0.3, 1e-5);
  EXPECT_LT(length(ray.legs[1].origin - Vec3f{0.5f, 0.1f, float(1 + 0.2 / slope)}), 1e-5f);
  EXPECT_NEAR(ray.legs[0].length, 0.2 / std::sin(inside), 1e-5);
  EXPECT_LT(length(ray.legs[2].origin - Vec3f{float(0.5 - (slope - 0.2)), 0.1f, 2}), 1e-5f);
  EXPECT_LT(length(ray.legs[2].direction - normalized(Vec3f{-1, 0, 1})), 1e-5f);
}

TEST(ThickGlass, KnowsWhatIsInItAndHowThickItIs) {
  const Vec3f centre{0.1f, -0.2f, 0.05f};
  const ThickGlass ball(shapes::sphere(centre, 0.6f, 60, 120), kGlassIor, 0.01f);
  EXPECT_TRUE(ball.contains(centre));
  EXPECT_TRUE(ball.contains(centre + Vec3f{0.4f, -0.3f, 0.2f}));
  EXPECT_FALSE(ball.contains(centre + Vec3f{0.5f, -0.4f, 0.2f}));
  EXPECT_FALSE(ball.contains({5, 0, 0}));
  const Vec3f up = normalized(Vec3f{1, 2, 3});
  ASSERT_TRUE(ball.thickness(centre + 0.598f * up, up).has_value());
  EXPECT_NEAR(*ball.thickness(centre + 0.598f * up, up), 1.198, 2e-3);
  TriMesh bowl = shapes::sphere(centre, 0.6f, 60, 120);
  std::erase_if(bowl.faces, [&](const auto& f) { return bowl.positions[f[0]].z < centre.z - 0.5f; });
  const ThickGlass standing(bowl, kGlassIor, 0.01f);
  EXPECT_FALSE(standing.thickness(centre + Vec3f{0, 0, 0.599f}, {0, 0, 1}).has_value());
  EXPECT_TRUE(standing.contains(centre)) << "a hole where it stands changes nothing";
}

TEST(ThickGlass, GlassInGlassIsOneAndTwoShellsBendTwice) {
  TriMesh two = shapes::sphere({0, 0, 1}, 0.3f, 60, 90);
  shapes::append(two, shapes::sphere({0, 0, 1}, 0.1f, 30, 45));
  const BentRay nested = ThickGlass(two, kGlassIor, 0.01f).path({0.02f, 0, 0}, {0, 0, 1}, 0.7f);
  EXPECT_EQ(nested.leg_count, 2u);
  shapes::append(two, shapes::sphere({0, 0, 2}, 0.3f, 60, 90));
  const BentRay both = ThickGlass(two, kGlassIor, 0.01f).path({0.02f, 0, 0}, {0, 0, 1}, 0.7f);
  EXPECT_EQ(both.path, GlassPath::Bent);
  EXPECT_EQ(both.leg_count, 4u);
  EXPECT_NEAR(both.legs[1].length, 0.4f, 0.02f);
}

// A ball of glass before a wall of many colours: what its pixels show is what the wall shows where Snell's law leads.
TEST(ThickGlass, PicturesShowWhatTheClosedFormShows) {
  const test::GlassBallScene ball;
  ImageOptions options = test::GlassBallScene::image();
  options.composite.layer_images = true;
  LayeredModel straight(options);
  options.transmission.thick = std::make_shared<ThickGlass>(shapes::sphere({}, ball.kBall, 100, 200), kGlassIor, 0.02f);
  LayeredModel bent(options);
  const View view = ball.view(0.3);
  Frame as_straight, as_bent;
  straight.forward(ball.scene, view, as_straight);
  bent.forward(ball.scene, view, as_bent);
  EXPECT_TRUE(as_straight.behind.path.empty());
  const size_t n = as_bent.pixel_count();
  double error = 0, error_straight = 0;
  size_t pixels = 0;
  const ImageF truth = ball.photo(view);
  for (size_t i = 0; i < n; ++i) {
    if (as_bent.behind.path[i] != GlassPath::Bent) {
      for (size_t c = 0; c < 3; ++c) EXPECT_EQ(as_bent.linear[c * n + i], as_straight.linear[c * n + i]);
      continue;
    }
    const auto exact = ball.through(view, i);
    if (!exact || exact->offset > 0.9) continue;
    ++pixels;
    for (size_t c = 0; c < 3; ++c) {
      error += std::pow(double(as_bent.layers.transmitted[c * n + i]) - double(truth.data()[3 * i + c]), 2);
      error_straight += std::pow(double(as_straight.layers.transmitted[c * n + i]) - double(truth.data()[3 * i + c]), 2);
    }
  }
  ASSERT_GT(pixels, 200u);
  const auto psnr = [&](double sum) { return -10 * std::log10(sum / double(3 * pixels)); };
  EXPECT_GT(psnr(error), 60);           // seen: 65.2
  EXPECT_LT(psnr(error_straight), 15);  // 12.0
}

// A pixel of a ball covers much of the room: pictures that nobody learns from take the mean of four rays.
TEST(ThickGlass, PicturesTakeTheMeanOfFourRaysAPixel) {
  const test::GlassBallScene ball;
  ImageOptions options = test::GlassBallScene::image();
  options.composite.layer_images = true;
  options.transmission.thick = std::make_shared<ThickGlass>(shapes::sphere({}, ball.kBall, 100, 200), kGlassIor, 0.1f);
  const LayeredModel model(options);
  const View view = ball.view(0.3);
  Frame frame;
  frame.differentiable = false;
  model.forward(ball.scene, view, frame);
  const size_t n = frame.pixel_count(), width = size_t(view.intrinsics.width);
  std::vector<uint32_t> pixels;
  std::vector<Vec3f> origins, directions;
  for (uint32_t i = 0; i < n; ++i) {
    const auto middle = ball.through(view, i);
    if (!middle || middle->offset > 0.85 || frame.behind.path[i] != GlassPath::Bent) continue;
    pixels.push_back(i);
    for (const auto& [dx, dy] : {std::pair{0.25, 0.25}, {0.75, 0.25}, {0.25, 0.75}, {0.75, 0.75}}) {
      const Vec3d d = normalized(view.ray(double(i % width) + dx, double(i / width) + dy));
      const auto way = test::through_ball(view.centre_in_world(), d, {}, ball.kBall, ball.kIor);
      origins.push_back(cast<float>(way->exit));
      directions.push_back(cast<float>(way->direction));
    }
  }
  ASSERT_GT(pixels.size(), 200u);
  const std::vector<Vec3f> colors = ball.wall_colors(origins, directions);
  double error = 0;
  for (size_t p = 0; p < pixels.size(); ++p)
    for (size_t c = 0; c < 3; ++c) {
      const float mean = (colors[4 * p][c] + colors[4 * p + 1][c] + colors[4 * p + 2][c] + colors[4 * p + 3][c]) / 4;
      const double off = double(frame.layers.transmitted[c * n + pixels[p]] - mean);
      error += off * off / double(3 * pixels.size());
    }
  EXPECT_LT(std::sqrt(error), 2e-3);
}

TEST(ThickGlass, GradientsMatchFiniteDifferences) {
  LayeredRoom r = room({.transmission = 0.85}, 5, 13, 11);
  const size_t glass = r.scene.diffuse.size();
  const Rigid world_from_cam = inverse(r.view.cam_from_world);
  const Vec3d axis = world_from_cam.rotation * Vec3d{0, 0, 1};
  scatter(r.scene.diffuse, world_from_cam * Vec3d{0, 0, 4}, axis, 4, 105);
  scatter(r.scene.transmittance, world_from_cam * Vec3d{0, 0, 4.15}, axis, 3, 205);
  scatter(r.scene.transmittance, world_from_cam * Vec3d{0, 0, 2.6}, axis, 1, 206);  // in the glass
  for (size_t i = glass; i < r.scene.diffuse.size(); ++i) *r.scene.diffuse.at(Attribute::Transmission, i) = logit(0.05f);
  // A plate of glass whose front is the pane.
  const Vec3d u = normalized(cross(r.normal, Vec3d{0, 1, 0})), v = cross(u, r.normal), edge = -1.4 * r.normal;
  const Mat3d frame{12.0 * u, 12.0 * v, edge};
  const Vec3d corner = r.point - 6.0 * u - 6.0 * v;
  ImageOptions options;
  options.diffuse.backend = Backend::Reference;
  options.surface.normal_quantile = 1;
  options.composite.gate = 0;
  options.transmission = {.glass = Glass::Thin, .backend = TracerBackend::Reference};
  options.transmission.thick = std::make_shared<ThickGlass>(glass_box(cast<float>(corner), cast<float>(frame)), kGlassIor, 0.5f);
  LayeredModel model(options);
  Frame frame_of;
  const auto loss = [&] {
    model.forward(r.scene, r.view, frame_of);
    return loss_of(frame_of);
  };
  loss();
  EXPECT_EQ(std::ranges::count(frame_of.behind.path, GlassPath::Bent), ptrdiff_t(frame_of.pixel_count()));
  start_gradient(frame_of);
  frame_of.error_image.assign(frame_of.pixel_count(), 1.f);
  SplatScene grad = r.scene.zeros_like();
  model.backward(r.scene, frame_of, grad);
  for (size_t i = glass; i < r.scene.diffuse.size(); ++i) EXPECT_GT(frame_of.statistics.error[i], 0.1f);
  for (float error : frame_of.transmission.statistics.error) EXPECT_GT(error, 0.1f);
  for (LayerKind kind : {LayerKind::Diffuse, LayerKind::Transmittance})
    for (Attribute a :
         {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc, Attribute::ShRest})
      expect_differences(r.scene, grad, kind, a, loss);
}

TEST(ThickGlass, BytesDoNotDependOnThreads) {
  const test::GlassBallScene ball;
  ImageOptions options = test::GlassBallScene::image();
  options.transmission.thick = std::make_shared<ThickGlass>(shapes::sphere({}, ball.kBall, 40, 60), kGlassIor, 0.02f);
  expect_same_for_threads(options, ball.scene, ball.view(0.5));
}

}  // namespace
}  // namespace vitrine
