// Precomputed transfer against closed forms and against the light that rays find.
#include "core/render/relight/light_transfer.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/foundation/base/parallel.h"
#include "core/render/relight/lit_scene.h"
#include "core/scene/light/environment.h"
#include "tests/core/render/relight/relit_ball.h"

namespace vitrine {
namespace {

Environment painted(Vec3f (*radiance)(const Vec3f&)) {
  ImageF map(64, 32, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const Vec3f l = radiance(lat_long_direction((float(x) + 0.5f) / 64, (float(y) + 0.5f) / 32));
      for (int c = 0; c < 3; ++c) map.at(x, y, c) = l[size_t(c)];
    }
  return Environment(std::move(map));
}

std::vector<Vec3f> of_surfels(const RelitScene& scene, const Environment& light, const TransferDesc& desc = {}) {
  const SceneSurface surface(scene);
  const CellLight cells = cell_light(light);
  const LightHarmonics harmonics = light_harmonics(light);
  std::vector<Vec3f> out;
  for (const ReceivedLight& r : LightTransfer(surface, desc).of_surfels(scene.trained.surfels.diffuse))
    out.push_back(irradiance(r, cells, harmonics));
  return out;
}

TEST(Octahedral, PlacesAndDirectionsAreInverse) {
  for (float x = -0.95f; x < 1; x += 0.1f)
    for (float y = -0.95f; y < 1; y += 0.1f) {
      const Vec2f p = octahedral_place(octahedral_direction(x, y));
      EXPECT_NEAR(p.x, x, 1e-5);
      EXPECT_NEAR(p.y, y, 1e-5);
    }
  EXPECT_GT(octahedral_direction(0, 0).z, 0.999f);
}

TEST(LightTransfer, HarmonicsOfAConstantLightAreItsMean) {
  const LightHarmonics h = light_harmonics(painted([](const Vec3f&) { return Vec3f{2, 1, 0}; }));
  EXPECT_NEAR(h[0].x, 2 * 4 * std::numbers::pi_v<float> * kShDc, 1e-4);
  for (size_t k = 1; k < kTransferSize; ++k) EXPECT_NEAR(h[k].x, 0, 0.01) << k;  // texels are steps
}

TEST(LightTransfer, ABallInAWhiteFurnaceIsFlat) {
  for (const Vec3f& e : of_surfels(test::relit_ball({1, 1, 1}), painted([](const Vec3f&) { return Vec3f{1, 1, 1}; }))) {
    EXPECT_NEAR(e.x, std::numbers::pi_v<float>, 0.03 * std::numbers::pi_v<float>);
    EXPECT_EQ(e.x, e.y);
  }
}

TEST(LightTransfer, ASmoothSkyFallsOnABallAsInClosedForm) {
  const RelitScene scene = test::relit_ball({0.5f, 0.5f, 0.5f});
  const std::vector<Vec3f> e = of_surfels(scene, painted([](const Vec3f& d) { return Vec3f{1 + d.z, 1 + d.x, 1}; }));
  for (size_t i = 0; i < e.size(); ++i) {
    const float* m = scene.trained.surfels.diffuse.at(Attribute::Mean, i);
    const Vec3f n = normalized(Vec3f{m[0], m[1], m[2]});
    EXPECT_NEAR(e[i].x, std::numbers::pi_v<float> * (1 + 2.f / 3 * n.z), 0.04 * std::numbers::pi_v<float>) << i;
    EXPECT_NEAR(e[i].y, std::numbers::pi_v<float> * (1 + 2.f / 3 * n.x), 0.04 * std::numbers::pi_v<float>) << i;
  }
}

TEST(LightTransfer, ALampOfOneTexelHasTheCosineOfItsPlace) {
  const Environment lamp = painted([](const Vec3f& d) {
    return dot(d, normalized(Vec3f{1, 2, 2})) > 0.9985f ? Vec3f{100, 0, 0} : Vec3f{};
  });
  const CellLight cells = cell_light(lamp);
  Vec3f flux{}, towards{};
  for (size_t c = 0; c < kCells; ++c) flux += cells.flux[c], towards += cells.flux[c].x * cells.direction[c];
  ASSERT_GT(flux.x, 0);
  EXPECT_NEAR(flux.x, light_harmonics(lamp)[0].x / kShDc, 1e-3 * flux.x);
  EXPECT_GT(dot(normalized(towards), normalized(Vec3f{1, 2, 2})), 0.999f);
}

// What rays find on the vertices of the mesh, shadows and three bounces included.
TEST(LightTransfer, AgreesWithRaysInACorner) {
  RelitScene scene = test::relit_ball({0.8f, 0.4f, 0.2f});
  scene.surroundings = test::sphere_mesh(0.3, {0, 0, 0.9}, 24, 48);  // hangs over the ball
  scene.surroundings.colors.assign(scene.surroundings.positions.size(), Vec3f{0.9f, 0.9f, 0.9f});
  const Environment sky = painted([](const Vec3f& d) { return d.z > 0 ? Vec3f{1, 1, 2} : Vec3f{0.2f, 0.1f, 0.1f}; });
  const SceneSurface surface(scene);
  Lighting lighting;
  lighting.environment = sky;
  const LitScene lit(surface, lighting, {.light_samples = 1024, .gather_rays = 256});
  const std::vector<Vec3f> e = of_surfels(scene, sky, {.rays = 256});
  double error = 0, mean = 0;
  for (size_t i = 0; i < e.size(); ++i) {
    const float* m = scene.trained.surfels.diffuse.at(Attribute::Mean, i);
    const Vec3f p{m[0], m[1], m[2]}, n = normalized(p);
    const auto place = surface.front_near(p + 0.1f * n, -n, 0.2f);
    ASSERT_TRUE(place.has_value());
    const Vec3f truth = surface.at(lit.irradiance(), *place);
    error += squared_length(truth - e[i]), mean += squared_length(truth);
  }
  EXPECT_LT(std::sqrt(error / mean), 0.05);
}

TEST(LightTransfer, TurnedLightIsTurnedOnTheBall) {
  const Environment sky = painted([](const Vec3f& d) { return Vec3f{1 + d.x, 1 + d.y * d.z, 1}; });
  const CellLight turned = cell_light(sky.rotated(90)), straight = cell_light(sky);
  // A quarter turn maps cells onto cells: (x, y) of the square to (-y, x).
  for (int y = 0; y < kCellSide; ++y)
    for (int x = 0; x < kCellSide; ++x) {
      const size_t from = size_t(y * kCellSide + x), to = size_t(x * kCellSide + kCellSide - 1 - y);
      EXPECT_NEAR(turned.flux[to].x, straight.flux[from].x, 1e-5);
      EXPECT_NEAR(turned.flux[to].y, straight.flux[from].y, 1e-5);
    }
}

TEST(LightTransfer, SameBytesForAnyNumberOfThreads) {
  const RelitScene scene = test::relit_ball({0.8f, 0.4f, 0.2f});
  const SceneSurface surface(scene);
  std::vector<std::vector<ReceivedLight>> all;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    all.push_back(LightTransfer(surface, {.rays = 16}).of_surfels(scene.trained.surfels.diffuse));
  }
  set_thread_limit(0);
  ASSERT_EQ(all[0].size(), all[1].size());
  for (size_t i = 0; i < all[0].size(); ++i) {
    EXPECT_EQ(all[0][i].open, all[1][i].open);
    EXPECT_EQ(all[0][i].bounced, all[1][i].bounced);
    EXPECT_EQ(all[0][i].normal, all[1][i].normal);
  }
}

}  // namespace
}  // namespace vitrine
