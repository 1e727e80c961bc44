#include "core/render/relight/relit_painter.h"

#include <cmath>
#include <csignal>
#include <numbers>

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/process.h"
#include "core/foundation/base/rng.h"
#include "tests/core/render/relight/relit_ball.h"
#include "tests/support/turned_ball.h"

namespace vitrine {
namespace {

using test::constant_light;
using test::relit_ball;
using test::view_from;

constexpr double kPi = std::numbers::pi;

struct Stats {
  double mean = 0, most = 0;
  int pixels = 0;
};
Stats inside(const RelitPicture& p, double least_coverage = 0.999) {
  Stats s;
  for (int y = 0; y < p.radiance.height(); ++y)
    for (int x = 0; x < p.radiance.width(); ++x)
      if (p.coverage.at(x, y) > least_coverage) {
        s.mean += p.radiance.at(x, y, 1);
        s.most = std::max(s.most, double(p.radiance.at(x, y, 1)));
        ++s.pixels;
      }
  s.mean /= s.pixels;
  return s;
}

TEST(RelitPainter, WhiteFurnace) {
  RelitPainter painter(relit_ball({1, 1, 1}));
  painter.set_lighting(constant_light(0.7f));
  const RelitPicture p = painter.picture(view_from({1, 0, 0.2}), {.samples = 64});
  const Stats ball = inside(p);
  EXPECT_GT(ball.pixels, 200);
  EXPECT_NEAR(ball.mean / 0.7, 1, 0.01);
  // The whole picture, outline included, is the light itself.
  for (int y = 0; y < p.radiance.height(); ++y)
    for (int x = 0; x < p.radiance.width(); ++x)  // within the noise of one pixel
      ASSERT_NEAR(p.radiance.at(x, y, 1) / 0.7, 1, 0.12) << "pixel " << x << ", " << y << " covered " << p.coverage.at(x, y);
}

TEST(RelitPainter, NoMaterialSendsOutMoreThanComesIn) {
  for (const float specular : {0.1f, 1.f}) {
    RelitScene scene = relit_ball({1, 1, 1});
    std::ranges::fill(scene.materials.specular_weight, specular);
    std::ranges::fill(scene.materials.f0, Vec3f{0.6f, 0.6f, 0.6f});
    RelitPainter painter(std::move(scene));
    painter.set_lighting(constant_light(1));
    const Stats ball = inside(painter.picture(view_from({1, 0, 0.2})));
    EXPECT_LE(ball.mean, 1.005);
    EXPECT_GT(ball.mean, 0.8);
  }
}

TEST(RelitPainter, AlbedoScalesAndTheBackgroundIsTheEnvironment) {
  RelitPainter painter(relit_ball({0.5f, 0.25f, 0.1f}));
  Lighting probe;
  probe.environment = axis_probe(64);
  painter.set_lighting(constant_light(1));
  const RelitPicture p = painter.picture(view_from({1, 0, 0}));
  EXPECT_NEAR(p.radiance.at(24, 18, 0), 0.5, 0.02);
  EXPECT_NEAR(p.radiance.at(24, 18, 1), 0.25, 0.01);
  EXPECT_NEAR(p.radiance.at(24, 18, 2), 0.1, 0.005);
  // A camera that looks along -x past the ball sees the cyan patch of -x.
  painter.set_lighting(probe);
  View aside = view_from({1, 0, 0});
  aside.cam_from_world = test::looking_at({1, 3, 0}, {0, 3, 0});
  const RelitPicture sky = painter.picture(aside);
  EXPECT_NEAR(sky.radiance.at(24, 18, 0), 0, 1e-6);
  EXPECT_NEAR(sky.radiance.at(24, 18, 1), 1, 1e-6);
}

// Lambert's law, with the light of one direction: no noise at all.
TEST(RelitPainter, ADirectionalLightShadesByTheCosine) {
  RelitPainter painter(relit_ball({0.8f, 0.8f, 0.8f}));
  Lighting sun;
  sun.directionals.push_back({{1, 0, 0}, {2, 2, 2}});
  painter.set_lighting(sun);
  const RelitPicture front = painter.picture(view_from({1, 0, 0}), {.samples = 4});
  EXPECT_NEAR(front.radiance.at(24, 18, 1), 0.8 * 2 / kPi, 0.02);
  const RelitPicture back = painter.picture(view_from({-1, 0, 0}), {.samples = 4});
  EXPECT_EQ(inside(back).most, 0);
  // Seen from the side: bright towards the sun, dark away from it.
  const RelitPicture side = painter.picture(view_from({0, -1, 0}), {.samples = 4});
  EXPECT_GT(side.radiance.at(32, 18, 1), 0.1);
  EXPECT_EQ(side.radiance.at(16, 18, 1), 0);
}

TEST(RelitPainter, LampsObeyTheInverseSquareAndAreasAgreeWithPoints) {
  RelitPainter painter(relit_ball({0.8f, 0.8f, 0.8f}));
  const auto middle = [&](const Lighting& light, int samples) {
    painter.set_lighting(light);
    return double(painter.picture(view_from({1, 0, 0}), {.samples = samples}).radiance.at(24, 18, 1));
  };
  Lighting near, far, disc;
  near.points.push_back({{1.4f, 0, 0}, {1, 1, 1}});
  far.points.push_back({{2.4f, 0, 0}, {1, 1, 1}});
  EXPECT_NEAR(middle(near, 1), 0.8 / kPi, 0.02);
  EXPECT_NEAR(middle(far, 1), 0.8 / kPi / 4, 0.01);
  // A small disc of the same intensity: radiance x area.
  AreaLight a{.center = {1.4f, 0, 0}, .normal = {-1, 0, 0}, .half_u = {0, 0.05f, 0}, .half_v = {0, 0, 0.05f}, .disc = true};
  a.radiance = Vec3f{1, 1, 1} / a.area();
  disc.areas.push_back(a);
  EXPECT_NEAR(middle(disc, 16), middle(near, 1), 0.01);
  disc.areas[0].normal = {1, 0, 0};  // turned away
  EXPECT_EQ(middle(disc, 16), 0);
}

// A plate between sun and ball: its shadow is dark under the sun alone.
TEST(RelitPainter, TheMeshThrowsShadowsAndBouncesLight) {
  RelitScene scene = relit_ball({0.8f, 0.8f, 0.8f});
  const auto first = static_cast<uint32_t>(scene.mesh.positions.size());
  for (const Vec3f p : {Vec3f{-0.3f, -0.3f, 1}, Vec3f{0.3f, -0.3f, 1}, Vec3f{0.3f, 0.3f, 1}, Vec3f{-0.3f, 0.3f, 1}})
    scene.mesh.positions.push_back(p);
  scene.mesh.faces.push_back({first, first + 2, first + 1});  // its front looks down
  scene.mesh.faces.push_back({first, first + 3, first + 2});
  scene.mesh.normals.clear();
  Lighting sun;
  sun.directionals.push_back({{0, 0, 1}, {3, 3, 3}});
  RelitPainter open(relit_ball({0.8f, 0.8f, 0.8f})), covered(std::move(scene));
  open.set_lighting(sun);
  covered.set_lighting(sun);
  View above = view_from({0.01, 0, 0.9});
  EXPECT_GT(open.picture(above).radiance.at(24, 18, 1), 0.7);
  EXPECT_LT(covered.picture(above).radiance.at(24, 18, 1), 0.05);
  // Light from below lights the plate's front, and that the top of the ball.
  Lighting below;
  below.directionals.push_back({{0, 0, -1}, {3, 3, 3}});
  open.set_lighting(below);
  covered.set_lighting(below);
  EXPECT_EQ(open.picture(above).radiance.at(24, 18, 1), 0);
  AreaLight ring{
      .center = {0, 0, 0.6f}, .normal = {0, 0, 1}, .half_u = {0.1f, 0, 0}, .half_v = {0, 0.1f, 0}, .radiance = {5, 5, 5}};
  below.areas.push_back(ring);
  open.set_lighting(below);
  covered.set_lighting(below);
  EXPECT_EQ(open.picture(above).radiance.at(24, 18, 1), 0);
  EXPECT_GT(covered.picture(above).radiance.at(24, 18, 1), 0.002);
}

// Walls are coarse: here one stands halfway before what its surfels show.
TEST(RelitPainter, WhatIsSeenThroughTheFrontOfItsWallHasTheLightThere) {
  const auto brightness = [](bool front_to_eye) {
    RelitScene scene = relit_ball({0.8f, 0.8f, 0.8f});
    scene.surroundings.positions = {{0.9f, -1, -1}, {0.9f, 1, -1}, {0.9f, 1, 1}, {0.9f, -1, 1}};
    scene.surroundings.colors.assign(4, {0.5f, 0.5f, 0.5f});
    scene.surroundings.faces = {{0, 1, 2}, {0, 2, 3}};  // front to +x
    if (!front_to_eye)
      for (auto& f : scene.surroundings.faces) std::swap(f[1], f[2]);
    Lighting sun;
    sun.directionals.push_back({{1, 0, 0}, {3, 3, 3}});
    RelitPainter painter(std::move(scene));
    painter.set_lighting(sun);
    return painter.picture(view_from({1.4, 0, 0.01})).radiance.at(24, 18, 1);
  };
  EXPECT_GT(brightness(true), 0.7);
  EXPECT_LT(brightness(false), 0.05);  // the eye stands behind the wall
}

// Meshes are rough by an edge or more where surfels are smooth.
TEST(RelitPainter, PitsAndLumpsOfTheMeshThrowNoShadows) {
  RelitScene smooth = relit_ball({0.8f, 0.8f, 0.8f}), rough = relit_ball({0.8f, 0.8f, 0.8f});
  const auto& mesh = smooth.mesh;
  const float edge = length(mesh.positions[mesh.faces[0][0]] - mesh.positions[mesh.faces[0][1]]);
  for (size_t v = 0; v < rough.mesh.positions.size(); ++v) {
    Vec3f& p = rough.mesh.positions[v];
    p += (3 * edge * (Rng(5, v).uniform() - 0.5f)) * normalized(p);
  }
  Lighting sun;
  sun.directionals.push_back({normalized(Vec3f{0.5f, 1, 0}), {2, 2, 2}});
  const auto picture = [&](RelitScene scene) {
    RelitPainter painter(std::move(scene));
    painter.set_lighting(sun);
    return painter.picture(view_from({1, 0, 0.2}, 96, 72)).radiance;
  };
  const ImageF expected = picture(std::move(smooth)), found = picture(std::move(rough));
  int lit = 0, black = 0;
  for (int y = 0; y < expected.height(); ++y)
    for (int x = 0; x < expected.width(); ++x)
      if (expected.at(x, y, 1) > 0.15) ++lit, black += found.at(x, y, 1) < 0.5 * expected.at(x, y, 1);
  ASSERT_GT(lit, 1000);
  EXPECT_LT(black, lit / 200) << lit;  // rays from one edge above the mesh: 106 of 3583
}

TEST(RelitPainter, ALampRightBelowACeilingShines) {
  const auto top = [](bool ceiling) {
    RelitScene scene = relit_ball({0.8f, 0.8f, 0.8f});
    const auto& f = scene.mesh.faces[0];
    const float above = 1 + length(scene.mesh.positions[f[0]] - scene.mesh.positions[f[1]]);
    if (ceiling) {
      scene.surroundings.positions = {{-1, -1, above}, {-1, 1, above}, {1, 1, above}, {1, -1, above}};
      scene.surroundings.colors.assign(4, {});
      scene.surroundings.faces = {{0, 1, 2}, {0, 2, 3}};
    }
    Lighting lamp;
    lamp.points.push_back({{0, 0, 1}, {1, 1, 1}});
    RelitPainter painter(std::move(scene));
    painter.set_lighting(lamp);
    return painter.picture(view_from({0.8, 0, 0.8})).radiance.at(24, 12, 1);
  };
  EXPECT_GT(top(false), 0.1);
  EXPECT_NEAR(top(true), top(false), 0.01 * top(false));
}

TEST(RelitPainter, AMirrorShowsTheNewEnvironment) {
  RelitScene scene = relit_ball({0, 0, 0});
  std::ranges::fill(scene.materials.specular_weight, 1.f);
  std::ranges::fill(scene.materials.roughness, 0.05f);
  RelitPainter painter(std::move(scene));
  Lighting probe;
  probe.environment = axis_probe(128);
  painter.set_lighting(probe);
  // Seen from +x, the middle of the ball mirrors +x: red.
  const RelitPicture p = painter.picture(view_from({1, 0, 0}));
  EXPECT_GT(p.radiance.at(24, 18, 0), 0.8);
  EXPECT_LT(p.radiance.at(24, 18, 2), 0.2);
  probe.environment = probe.environment.rotated(90);  // now the red patch shines from +y, and -y's magenta from +x
  painter.set_lighting(probe);
  const RelitPicture q = painter.picture(view_from({1, 0, 0}));
  EXPECT_GT(q.radiance.at(24, 18, 2), 0.8);
}

// The highlight of a ball turned about the vertical is a band along the meridian; brushed along the vertical, one around the
// ball.
TEST(RelitPainter, HighlightsOfBrushedMetalRunAcrossItsMarks) {
  RelitScene scene = relit_ball({0, 0, 0});
  std::ranges::fill(scene.materials.f0, Vec3f{1, 1, 1});
  std::ranges::fill(scene.materials.roughness, 0.35f);
  std::ranges::fill(scene.materials.specular_weight, 1.f);
  Lighting light;
  light.environment = Environment(ImageF(16, 8, 3, 0.f));
  light.directionals = {{.towards = {1, 0, 0}, .irradiance = {1, 1, 1}}};
  const View view = view_from({2, 0, 0});
  // Extent of the highlight upwards over its extent sideways.
  const auto upright = [&](bool turned) {
    scene.materials.marks.resize(scene.materials.size());
    for (size_t i = 0; i < scene.materials.size(); ++i) {
      const float* p = scene.trained.surfels.diffuse.at(Attribute::Mean, i);
      scene.materials.marks[i] = turned ? 0.7f * normalized(Vec3f{-p[1], p[0], 0} + Vec3f{0, 1e-6f, 0}) : Vec3f{0, 0, 0.7f};
    }
    RelitPainter painter(scene);
    painter.set_lighting(light);
    const ImageF picture = painter.picture(view, {.samples = 1}).radiance;
    double sum = 0, xx = 0, yy = 0;
    for (int y = 0; y < picture.height(); ++y)
      for (int x = 0; x < picture.width(); ++x) {
        const double v = picture.at(x, y, 0), dx = x + 0.5 - picture.width() / 2.0, dy = y + 0.5 - picture.height() / 2.0;
        sum += v, xx += v * dx * dx, yy += v * dy * dy;
      }
    EXPECT_GT(sum, 0);
    return std::sqrt(yy / xx);
  };
  EXPECT_GT(upright(true), 1.3);
  EXPECT_LT(upright(false), 1 / 1.3);
}

TEST(RelitPainter, TheBytesDoNotDependOnThreads) {
  Lighting light;
  light.environment = axis_probe(64);
  light.areas.push_back(
      {.center = {1, 0, 1}, .normal = {-1, 0, 0}, .half_u = {0, 0.2f, 0}, .half_v = {0, 0, 0.2f}, .radiance = {2, 2, 2}});
  std::vector<ImageF> pictures;
  for (const int threads : {1, 3}) {
    set_thread_limit(threads);
    RelitPainter painter(relit_ball({0.8f, 0.7f, 0.6f}));
    painter.set_lighting(light);
    pictures.push_back(painter.picture(view_from({0.8, 0.5, 0.2}), {.samples = 8}).radiance);
  }
  set_thread_limit(0);
  EXPECT_EQ(pictures[0], pictures[1]);
}

// Training turns the surfels of a mirror as its pictures want them.
TEST(RelitPainter, MirrorsHaveTheNormalsOfTheMesh) {
  ImageF sky(32, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x)
      for (int c = 0; c < 3; ++c) sky.at(x, y, c) = 1 - float(y) / 16;
  const auto centre = [&](bool turned, float metal) {
    RelitScene scene = test::relit_ball(metal > 0 ? Vec3f{} : Vec3f{0.8f, 0.8f, 0.8f});
    std::ranges::fill(scene.materials.specular_weight, metal);
    std::ranges::fill(scene.materials.f0, Vec3f{metal, metal, metal});
    std::ranges::fill(scene.materials.roughness, 0.2f);
    SplatLayer& surfels = scene.trained.surfels.diffuse;
    for (size_t i = 0; turned && i < surfels.size(); ++i) {  // all look up
      const float flat[] = {1, 0, 0, 0};
      std::copy_n(flat, 4, surfels.at(Attribute::Rotation, i));
    }
    RelitPainter painter(std::move(scene));
    painter.set_lighting({.environment = Environment(sky), .points = {}, .directionals = {}, .areas = {}});
    return painter.picture(test::view_from({1, 0, 0.5}), {.samples = 64}).radiance.at(24, 18, 0);
  };
  EXPECT_NEAR(centre(true, 1), centre(false, 1), 0.05);
  EXPECT_GT(std::abs(centre(true, 0) - centre(false, 0)), 0.05);
}

// And those of known shape have its place and normals, whatever the mesh is.
TEST(RelitPainter, MirrorsOfKnownShapeHaveItsNormals) {
  ImageF sky(32, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 32; ++x)
      for (int c = 0; c < 3; ++c) sky.at(x, y, c) = 1 - float(y) / 16;
  const auto above_centre = [&](bool pressed, bool known) {
    RelitScene scene = test::relit_ball({});
    std::ranges::fill(scene.materials.specular_weight, 1.f);
    std::ranges::fill(scene.materials.roughness, 0.05f);
    if (pressed)
      for (Vec3f& p : scene.mesh.positions) p.z *= 0.8f;
    scene.mesh.normals.clear();
    if (known)
      scene.trained.image.shape.set =
          std::make_shared<const ShapeSet>(ShapeSet{{{test::turned_ball({0, 0, 0}, 0.4), ShapeRole::Mirror, 0.02, -1, {}}}});
    RelitPainter painter(std::move(scene));
    painter.set_lighting({.environment = Environment(sky), .points = {}, .directionals = {}, .areas = {}});
    return painter.picture(test::view_from({1, 0, 0}), {.samples = 64}).radiance.at(24, 12, 0);
  };
  const float truth = above_centre(false, false);
  EXPECT_NEAR(above_centre(true, true), truth, 0.01);
  EXPECT_GT(std::abs(above_centre(true, false) - truth), 0.03);
}

// Photos show backs of things in mirrors alone; the mesh has their fronts.
TEST(RelitPainter, BacksInAMirrorAreNotBlack) {
  RelitScene scene = test::relit_ball({});
  std::ranges::fill(scene.materials.specular_weight, 1.f);
  std::ranges::fill(scene.materials.roughness, 0.05f);
  scene.surroundings.positions = {{2, -1, -1}, {2, 1, -1}, {2, 1, 1}, {2, -1, 1}};
  scene.surroundings.colors.assign(4, {0.5f, 0.5f, 0.5f});
  scene.surroundings.faces = {{0, 1, 2}, {0, 2, 3}};  // facing away
  RelitPainter painter(std::move(scene));
  painter.set_lighting(test::constant_light(1));
  EXPECT_NEAR(painter.picture(test::view_from({1, 0, 0}), {.samples = 16}).radiance.at(24, 18, 0), 0.5, 0.1);
}

TEST(RelitPainter, StopsWhenAskedToWhileTheLightIsSetUp) {
  for (const bool glass : {false, true})
    EXPECT_EXIT(
        {
          RelitPainter painter(glass ? test::ball_in_glass(Glass::Thin) : relit_ball({1, 1, 1}));
          install_interrupt_handlers();
          std::raise(SIGTERM);
          try {
            painter.set_lighting(constant_light(1));
          } catch (const Error& e) {
            _exit(exit_code(e.kind()));
          }
          _exit(0);
        },
        ::testing::ExitedWithCode(exit_code(ErrorKind::Preempted)), "");
}

}  // namespace
}  // namespace vitrine
