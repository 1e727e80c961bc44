// A painted ball inside a ball of clear glass.
#include "core/render/relight/relit_painter.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/scene/shape/shape_set.h"
#include "tests/core/render/relight/relit_ball.h"

namespace vitrine {
namespace {

TEST(GlassContent, FollowsTheLightThatReachesItThroughTheGlass) {
  for (const Glass glass : {Glass::Thin, Glass::Traced}) {
    RelitPainter painter(test::ball_in_glass(glass));
    const auto middle = [&](const Lighting& light) {
      painter.set_lighting(light);
      return painter.picture(test::view_from({1, 0, 0}), {.samples = 4}).radiance;
    };
    // The light of the photos shows the trained colour; twice the light, twice the colour.
    const ImageF before = middle(test::constant_light(1)), twice = middle(test::constant_light(2));
    const float trained[3] = {0.65f, 0.35f, 0.35f};  // of the ball's point that faces the camera
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(before.at(24, 18, c), trained[c], 0.02);
      EXPECT_NEAR(twice.at(24, 18, c), 2 * before.at(24, 18, c), 0.02 * before.at(24, 18, c));
    }
    // Beside the inner ball, what lies beyond the glass.
    EXPECT_NEAR(before.at(24, 2, 0), 1, 0.02);
    EXPECT_NEAR(twice.at(24, 2, 0), 2, 0.04);
  }
}

// What has an albedo scatters the light that reaches its front through the glass, and stands in its own shadow.
TEST(GlassContent, KnownAlbedoIsLitOnItsFront) {
  constexpr float kPi = std::numbers::pi_v<float>;
  constexpr float kAlbedo[] = {0.5f, 0.3f, 0.2f};
  for (const bool meshed : {true, false}) {
    RelitScene scene = test::ball_in_glass(Glass::Thin);
    scene.materials.albedo_behind_glass.assign(scene.trained.surfels.transmittance.size(), {kAlbedo[0], kAlbedo[1], kAlbedo[2]});
    if (meshed) scene.behind_glass = test::sphere_mesh(0.2, {}, 48, 96);
    RelitPainter painter(std::move(scene));
    Lighting sun;
    sun.environment = Environment(ImageF(8, 4, 3, 0.f));
    sun.directionals.push_back({.towards = {0, 0, 1}, .irradiance = {kPi, kPi, kPi}});
    painter.set_lighting(sun);
    const auto middle = [&](const Vec3d& eye, int c) {
      return painter.picture(test::view_from(eye), {.samples = 4}).radiance.at(24, 18, c);
    };
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(middle({0.8, 0, 0.6}, c), 0.6f * kAlbedo[c], 0.06f * kAlbedo[c]) << meshed;
      EXPECT_LT(middle({0.8, 0, -0.6}, c), 0.1f * kAlbedo[c]) << meshed;
    }
  }
}

// A polished ball, and around it a ball of clear glass that belongs to the surfels.
RelitScene metal_in_glass(float glass_transmission) {
  RelitScene s = test::relit_ball({}, 0.2);
  const RelitScene around = test::relit_ball({}, 0.4);
  const size_t inner = s.materials.size(), outer = around.materials.size();
  std::fill_n(s.materials.specular_weight.begin(), inner, 1.f);
  std::fill_n(s.materials.f0.begin(), inner, Vec3f{1, 1, 1});
  std::fill_n(s.materials.roughness.begin(), inner, 0.05f);
  s.materials.resize(inner + outer);
  SplatLayer& layer = s.trained.surfels.diffuse;
  layer.resize(inner + outer);
  for (size_t i = 0; i < outer; ++i) {
    for (const Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity})
      std::copy_n(around.trained.surfels.diffuse.at(a, i), layer.width(a), layer.at(a, inner + i));
    s.materials.albedo[inner + i] = {0.01f, 0.01f, 0.01f};
    s.materials.transmission[inner + i] = glass_transmission;
  }
  const auto first = static_cast<uint32_t>(s.mesh.positions.size());
  s.mesh.positions.insert(s.mesh.positions.end(), around.mesh.positions.begin(), around.mesh.positions.end());
  s.mesh.normals.insert(s.mesh.normals.end(), around.mesh.normals.begin(), around.mesh.normals.end());
  for (const auto& f : around.mesh.faces) s.mesh.faces.push_back({f[0] + first, f[1] + first, f[2] + first});
  // Next to nothing that only glass shows.
  s.trained.surfels.transmittance = SplatLayer(LayerKind::Transmittance, 0, 1);
  *s.trained.surfels.transmittance.at(Attribute::Opacity, 0) = -20;
  s.trained.surfels.transmittance.at(Attribute::Mean, 0)[2] = 9;
  s.trained.image.transmission.glass = Glass::Thin;
  return s;
}

TEST(GlassContent, MetalBehindItMirrorsTheNewLight) {
  Lighting probe;
  probe.environment = axis_probe(128);
  const auto middle = [&](float clear) {
    RelitPainter painter(metal_in_glass(clear));
    painter.set_lighting(probe);
    const ImageF p = painter.picture(test::view_from({1, 0, 0}), {.samples = 64}).radiance;
    return Vec3f{p.at(24, 18, 0), p.at(24, 18, 1), p.at(24, 18, 2)};
  };
  // Seen from +x, the middle of the ball mirrors +x: red.
  const Vec3f seen = middle(1);
  EXPECT_GT(seen.x, 0.75);
  EXPECT_LT(seen.z, 0.2);
  EXPECT_LT(middle(0).x, 0.1);  // glass that lets nothing through
}

// A sheet that training knew as a shape, and nothing that only glass shows.
TEST(GlassContent, KnownSheetsAreClearWithoutATransmittanceLayer) {
  RelitScene scene = test::relit_ball({0.5f, 0.5f, 0.5f}, 0.2);
  Lighting sun;
  sun.directionals.push_back({{1, 0, 0}, {1, 1, 1}});
  const auto red = [&](RelitScene s) {  // of a slope of the ball
    RelitPainter painter(std::move(s));
    painter.set_lighting(sun);
    return painter.picture(test::view_from({1, 0, 0}), {.samples = 16}).radiance.at(33, 18, 0);
  };
  const float open = red(scene);
  scene.trained.image.transmission.glass = Glass::Thin;
  auto known = std::make_shared<ShapeSet>();
  ShapeSet::Entry& box = known->entries.emplace_back();
  box.shape = Box{.axes = Mat3d::identity(), .low = {-0.4, -0.4, -0.4}, .high = {0.4, 0.4, 0.4}};
  box.role = ShapeRole::Sheet;
  box.tolerance = 0.01;
  scene.trained.image.shape.set = known;
  const float behind = red(scene);
  EXPECT_GT(behind, 0.7f * open);  // the sheet mirrors a tenth
  EXPECT_LT(behind, 1.05f * open);
}

TEST(GlassContent, SolidThingsKeepTheLightOut) {
  RelitScene scene = test::ball_in_glass(Glass::Thin);
  std::ranges::fill(scene.materials.transmission, 0.f);
  RelitPainter painter(std::move(scene));
  painter.set_lighting(test::constant_light(1));
  EXPECT_NEAR(painter.picture(test::view_from({1, 0, 0}), {.samples = 16}).radiance.at(24, 18, 0), 0.1, 0.01);
  EXPECT_EQ(painter.lit().surface().visibility({0, 0, 0}, {1, 0, 0}), 0);
}

}  // namespace
}  // namespace vitrine
