// The parts that the decomposition is put together from: directions, light that reaches points, and what points lend each other.
#include "stages/decompose/transport.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/rng.h"
#include "stages/decompose/lit_points.h"

namespace vitrine {
namespace {

TEST(LightGrid, CellsHoldTheirDirectionsAndTileTheSphere) {
  const LightGrid grid{.bands = 6};
  EXPECT_NEAR(grid.solid_angle() * float(grid.cells()), 4 * std::numbers::pi, 1e-4);
  Rng rng(5);
  for (size_t j = 0; j < grid.cells(); ++j)
    for (int k = 0; k < 8; ++k)
      EXPECT_EQ(grid.cell_of(grid.direction(j, 0.01f + 0.98f * rng.uniform(), 0.01f + 0.98f * rng.uniform())), j);
}

// A sheet in the plane z with corners at +-1, vertices of one colour; its front looks up or down.
TriMesh sheet(float z, bool up, const Vec3f& color) {
  TriMesh m;
  m.positions = {{-1, -1, z}, {1, -1, z}, {1, 1, z}, {-1, 1, z}};
  m.colors.assign(4, color);
  m.faces = up ? std::vector<std::array<uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}
               : std::vector<std::array<uint32_t, 3>>{{0, 2, 1}, {0, 3, 2}};
  return m;
}

Transport transport_over(const TriMesh& mesh, const std::vector<LitPoint>& points) {
  const Surroundings open{.centre = {},
                          .height = 4,
                          .distance = std::vector<float>(32, 0.f),
                          .radiance = std::vector<Vec3f>(32),
                          .wall = std::vector<bool>(32, false)};
  return transport({.mesh = mesh, .transmission = {}, .around = open, .shell = {}}, points, {.grid = {.bands = 24}},
                   [](double) {});
}

TEST(Transport, LightFromBehindASurfaceDoesNotReachIt) {
  const auto facing = [](const Vec3f& n) { return LitPoint{.normal = n, .inner = true}; };
  const Transport t = transport_over(sheet(0, true, {}), {facing({0, 0, 1}), facing({0, 0, -1})});
  std::vector<Vec3f> above(t.grid.cells()), below(t.grid.cells());
  for (size_t j = 0; j < t.grid.cells(); ++j) (t.grid.direction(j, 0.5f, 0.5f).z > 0 ? above : below)[j] = {1, 2, 3};
  EXPECT_NEAR(t.irradiance(0, above).x, std::numbers::pi, 0.02);
  EXPECT_NEAR(t.irradiance(0, above).z, 3 * std::numbers::pi, 0.06);
  EXPECT_EQ(t.irradiance(0, below), Vec3f{});
  EXPECT_EQ(t.irradiance(1, above), Vec3f{});
}

TEST(Transport, ASheetSendsOnTheLightOfItsFrontToItsFrontOnly) {
  const LitPoint below{.position = {0, 0, -0.05f}, .normal = {0, 0, 1}, .inner = true};
  const Transport lit_below = transport_over(sheet(0, false, {2, 1, 0.5f}), {below});
  EXPECT_NEAR(lit_below.known[0].x, 2 * std::numbers::pi, 0.05);
  EXPECT_EQ(lit_below.inside[0], 0);
  const Transport lit_above = transport_over(sheet(0, true, {2, 1, 0.5f}), {below});
  EXPECT_EQ(lit_above.known[0], Vec3f{});
  EXPECT_GT(lit_above.inside[0], 0.9f);
}

TEST(Spread, TheTwoSidesOfAThinThingKeepTheirOwnLight) {
  constexpr float kThick = 0.01f;
  constexpr int kSide = 12;
  std::vector<LitPoint> points;
  std::vector<Vec3f> light;
  SplatLayer layer(LayerKind::Diffuse, 0, 4 * kSide * kSide);
  for (int i = 0; i < kSide * kSide; ++i)
    for (const bool top : {true, false}) {
      const Vec3f p{0.01f * float(i % kSide), 0.01f * float(i / kSide), top ? kThick : 0.f};
      points.push_back({.position = p, .normal = {0, 0, top ? 1.f : -1.f}, .inner = true});
      light.push_back(top ? Vec3f{5, 5, 5} : Vec3f{1, 1, 1});
      for (const bool turned : {false, true}) {  // which way a surfel's own normal looks means nothing
        const size_t s = 4 * size_t(i) + 2 * top + turned;
        for (size_t c = 0; c < 3; ++c) layer.at(Attribute::Mean, s)[c] = p[c] + (c == 2 ? 0.001f : 0.003f);
        layer.at(Attribute::Rotation, s)[turned ? 1 : 0] = 1;  // half a turn about x
        if (turned) layer.at(Attribute::Rotation, s)[0] = 0;
      }
    }
  Bounds3 box;
  box.extend({-1, -1, -1});
  box.extend({1, 1, 1});
  const std::vector<Vec3f> spread = spread_irradiance(layer, box, points, light, std::vector<bool>(points.size(), true),
                                                      {.inner_radius = 0.01f, .outer_radius = 0.06f});
  for (size_t s = 0; s < spread.size(); ++s) ASSERT_NEAR(spread[s].x, s % 4 >= 2 ? 5 : 1, 1e-4) << s;
}

TEST(Affinity, PairsTheSamePaintAndNoOther) {
  std::vector<Vec3f> positions, radiance;
  Rng rng(9);
  for (int i = 0; i < 300; ++i) {
    positions.push_back({rng.uniform(), rng.uniform(), 0});
    const float light = 0.1f + rng.uniform();
    radiance.push_back(light * (i % 2 ? Vec3f{0.8f, 0.2f, 0.2f} : Vec3f{0.2f, 0.3f, 0.8f}));
  }
  const Affinity a = affinity(positions, radiance, {.radius = 0.2f, .clusters = 4});
  size_t partners = 0;
  for (size_t i = 0; i < positions.size(); ++i)
    for (const Affinity::Partner& p : a.of(i)) {
      EXPECT_EQ(p.point % 2, i % 2);
      ++partners;
    }
  EXPECT_GT(partners, 10 * positions.size());
}

}  // namespace
}  // namespace vitrine
