#include "stages/decompose/metals.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "core/light/environment.h"
#include "core/math/spherical_harmonics.h"
#include "stages/decompose/light_solver.h"
#include "tests/support/error_of.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/turned_ball.h"

namespace vitrine {
namespace {

// A polished ball under a light that is bright in two directions and dim between them.
class PolishedBall {
 public:
  static constexpr Vec3f kCopper{0.9f, 0.6f, 0.45f}, kPaint{0.12f, 0.2f, 0.3f};

  // What a photo shows of the ball: `paint` + reflectance(cosine) * light of the mirrored direction.
  PolishedBall(const Vec3f& paint, const std::function<Vec3f(float cosine)>& reflectance) : environment(light()) {
    scene.surfels.diffuse = capture.layer;
    mesh = test::sphere_mesh(test::TinyCapture::kRadius);
    for (const View& v : capture.views) {
      const Intrinsics& k = v.intrinsics;
      ImageF photo(k.width, k.height, 3);
      const Vec3d eye = v.centre_in_world();
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const Vec3d d = normalized(transposed_times(v.cam_from_world.rotation, k.ray(x + 0.5, y + 0.5)));
          const double along = -dot(eye, d), off = length(eye + along * d), r = test::TinyCapture::kRadius;
          if (off >= r) continue;
          const Vec3d n = normalized(eye + (along - std::sqrt(r * r - off * off)) * d);
          const float cosine = float(-dot(n, d));
          const Vec3f c = paint + hadamard(reflectance(cosine), environment.radiance(cast<float>(d + 2 * double(cosine) * n)));
          for (int i = 0; i < 3; ++i) photo.at(x, y, i) = float(v.gain[size_t(i)]) * c[size_t(i)];
        }
      write_exr_rgb(linear_image_path(capture.sfm(), v), photo, ExrPrecision::Float);
    }
  }
  Metals metals(float marked = 1, const std::vector<MeshVerdict>& verdicts = {}) const {
    const auto mask = [&](const View&, const Intrinsics& k) { return ImageF(k.width, k.height, 1, marked); };
    return find_metals({.sfm_folder = capture.sfm(),
                        .scene = scene,
                        .mesh = mesh,
                        .views = capture.views,
                        .environment = environment,
                        .mirrors = mask,
                        .glass_or_mirrors = mask,
                        .verdicts = verdicts});
  }

  test::TinyCapture capture;
  TrainedScene scene;
  TriMesh mesh;
  Environment environment;

 private:
  static ImageF light() {
    ImageF map(64, 32, 3);
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 64; ++x)
        for (int c = 0; c < 3; ++c)
          map.at(x, y, c) = (0.45f + 0.42f * float(std::sin(4 * std::numbers::pi * (x + 0.5) / 64))) * (c == 2 ? 0.8f : 1.f);
    return map;
  }
};

TEST(Metals, CopperIsCopper) {
  const PolishedBall ball({}, [](float) { return PolishedBall::kCopper; });
  const Metals found = ball.metals();
  ASSERT_EQ(found.things.size(), 1u);
  EXPECT_TRUE(found.things[0].metal) << found.things[0].lower_half;
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(found.things[0].reflectance[c], PolishedBall::kCopper[c], 0.04);
  EXPECT_GT(std::ranges::count(found.of_surfel, 0), std::ptrdiff_t(found.of_surfel.size() * 2 / 3));
}

// The mesh has the shape that goes with its own verdict: whatever is measured here, that one counts.
TEST(Metals, TheMeshStageHasTheFirstWord) {
  const PolishedBall copper({}, [](float) { return PolishedBall::kCopper; });
  const Bounds3 around{{-1, -1, -1}, {1, 1, 1}}, beside{{1, 1, 1}, {2, 2, 2}};
  EXPECT_FALSE(copper.metals(1, {{beside, true}, {around, false}}).things.at(0).metal);
  EXPECT_TRUE(copper.metals(1, {{around, true}}).things.at(0).metal);
  EXPECT_TRUE(copper.metals(1, {{beside, false}}).things.at(0).metal) << "of something else";
}

// Silhouettes of things that touch are one hull, with one verdict.
TEST(Metals, KnownShapesAreThingsOfTheirOwn) {
  PolishedBall copper({}, [](float) { return PolishedBall::kCopper; });
  const Bounds3 around{{-1, -1, -1}, {1, 1, 1}};
  const auto as = [&](ShapeRole role, bool verdict) {
    copper.scene.image.shape.set = std::make_shared<const ShapeSet>(
        ShapeSet{{{test::turned_ball({0, 0, 0}, test::TinyCapture::kRadius), role, 0.01, -1, {}}}});
    return copper.metals(1, {{around, verdict}}).things.at(0);
  };
  const Polished mirror = as(ShapeRole::Mirror, false);
  EXPECT_TRUE(mirror.metal);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(mirror.reflectance[c], PolishedBall::kCopper[c], 0.04);
  EXPECT_FALSE(as(ShapeRole::Coat, true).metal);

  // One half of the ball alone is known, by a shape that leaves it further down.
  SurfaceOfRevolution upper = test::turned_ball({0, 0, 0}, test::TinyCapture::kRadius);
  for (Vec2d& p : upper.profile)
    if (p.y < 0) p.x *= 0.3;
  copper.scene.image.shape.set = std::make_shared<const ShapeSet>(ShapeSet{{{upper, ShapeRole::Mirror, 0.01, -1, {}}}});
  const Metals halves = copper.metals(1, {{around, false}});
  ASSERT_EQ(halves.things.size(), 2u);
  EXPECT_NE(halves.things[0].metal, halves.things[1].metal);
  // What hangs together with it, and is metal to the mesh stage, belongs to it.
  const Metals whole = copper.metals(1, {{around, true}});
  ASSERT_EQ(whole.things.size(), 1u);
  EXPECT_TRUE(whole.things[0].metal);
}

TEST(MeshVerdicts, AreReadFromTheReportOfTheMesh) {
  const TemporaryFolder folder;
  const fs::path report = folder.path() / "report.json";
  EXPECT_TRUE(mesh_verdicts(report).empty());
  for (const char* none : {R"({"voxel": 1})", R"({"mirrors": {"low": [0, 0, 0]}})", R"({"mirrors": []})"}) {
    write_file(report, none);
    EXPECT_TRUE(mesh_verdicts(report).empty()) << none;
  }
  write_file(report, R"({"mirrors": [{"kind": "glaze", "low": [0, 1, 2], "high": [3, 4, 5]},
                                     {"kind": "metal", "low": [0, 0, 0], "high": [1, 1, 1]}]})");
  const auto verdicts = mesh_verdicts(report);
  ASSERT_EQ(verdicts.size(), 2u);
  EXPECT_FALSE(verdicts[0].metal);
  EXPECT_EQ(verdicts[0].bounds.high, (Vec3d{3, 4, 5}));
  EXPECT_TRUE(verdicts[1].metal);
  for (const char* bad :
       {"{", R"({"mirrors": [{"kind": "metal"}]})", R"({"mirrors": [{"kind": "metal", "low": [1], "high": []}]})"}) {
    write_file(report, bad);
    EXPECT_EQ(error_of([&] { mesh_verdicts(report); }).detail().code, "BAD_MESH_REPORT") << bad;
  }
}

TEST(Metals, WhatStandsDeepInsideIsAPictureInIt) {
  PolishedBall ball({}, [](float) { return PolishedBall::kCopper; });
  SplatLayer& layer = ball.scene.surfels.diffuse;
  const size_t deep = layer.size() / 2, apart = deep + 1;
  for (size_t c = 0; c < 3; ++c) {
    layer.at(Attribute::Mean, deep)[c] *= 0.6f;   // 0.16 below the surface, beyond the reach of 0.05
    layer.at(Attribute::Mean, apart)[c] *= 1.6f;  // as far before it: something else
  }
  const Metals found = ball.metals();
  EXPECT_EQ(found.of_surfel[deep], 0);
  EXPECT_EQ(found.of_surfel[apart], -1);
}

TEST(Metals, HandlesAndKnobsAreNotTheKettlesMetal) {
  PolishedBall ball({}, [](float) { return PolishedBall::kCopper; });
  SplatLayer& layer = ball.scene.surfels.diffuse;
  const auto set = [&](size_t i, float specular, float color) {
    *layer.at(Attribute::SpecularWeight, i) = specular;  // raw
    for (size_t c = 0; c < 3; ++c) layer.at(Attribute::ShDc, i)[c] = (color - 0.5f) / kShDc;
  };
  for (size_t i = 0; i < layer.size(); ++i) set(i, 2, 0.01f);
  const size_t handle = layer.size() / 2, spout = handle + 1, dark = handle + 2;
  set(handle, -4, 0.02f);
  set(spout, -4, 0.4f);  // as bright as the copper: its pictures were painted on it
  set(dark, 2, 0.f);     // a mirror, whose own colour is black
  const Metals found = ball.metals();
  EXPECT_EQ(found.of_surfel[handle], -1);
  EXPECT_EQ(found.of_surfel[spout], 0);
  EXPECT_EQ(found.of_surfel[dark], 0);
}

TEST(Metals, GlossIsTakenFromThePaintOfAGlaze) {
  const PolishedBall ball(PolishedBall::kPaint, [](float cosine) { return schlick(Vec3f{0.04f, 0.04f, 0.04f}, cosine).value; });
  const Metals found = ball.metals();
  ASSERT_EQ(found.things.size(), 1u);
  EXPECT_FALSE(found.things[0].metal) << found.things[0].lower_half;
  // Over the ball's belt, which many views see: what the photos show in the mean, and what is left of it.
  Vec3d gloss{};
  double count = 0;
  for (size_t i = 0; i < found.gloss.size(); ++i)
    if (std::abs(ball.scene.surfels.diffuse.at(Attribute::Mean, i)[2]) < 0.2f) gloss += cast<double>(found.gloss[i]), count += 1;
  gloss = gloss / count;
  // 0.04 to 0.07 of a light whose mean is 0.45: within what the dimmer half of a handful of pixels leaves.
  EXPECT_GT(gloss.x, 0.012);
  EXPECT_LT(gloss.x, 0.045);
  EXPECT_NEAR(gloss.z / gloss.x, 0.8, 0.1);
}

TEST(Metals, MetalsLoseTheirPaintAndGlazesTheirGloss) {
  TrainedScene scene;
  scene.image.composite.blend = LayerBlend::Layered;
  Metals found;
  found.things = {{.metal = true, .reflectance = PolishedBall::kCopper}, {.reflectance = {0.04f, 0.04f, 0.04f}}};
  found.of_surfel = {-1, 0, 1};
  found.gloss = {{}, {}, {0.1f, 0.1f, 0.1f}};
  DecomposedMaterials materials;
  materials.resize(3);
  std::ranges::fill(materials.albedo, Vec3f{0.4f, 0.4f, 0.4f});
  polish_materials(found, scene, {{0.2f, 0.2f, 0.2f}, {0.2f, 0.2f, 0.2f}, {0.2f, 0.4f, 0.05f}}, materials);
  EXPECT_EQ(materials.albedo[0], (Vec3f{0.4f, 0.4f, 0.4f}));
  EXPECT_EQ(materials.albedo[1], Vec3f{});
  EXPECT_NEAR(materials.albedo[2].x, 0.2f, 1e-6);
  EXPECT_NEAR(materials.albedo[2].y, 0.3f, 1e-6);
  EXPECT_NEAR(materials.albedo[2].z, 0.04f, 1e-6);  // a tenth stays, whatever the gloss
  EXPECT_GT(materials.f0[1].x, 0.8f);
  EXPECT_LT(materials.f0[2].x, 0.05f);
}

TEST(Metals, WithoutMarksThereIsNone) {
  const PolishedBall ball({}, [](float) { return PolishedBall::kCopper; });
  const Metals found = ball.metals(0);
  EXPECT_TRUE(found.things.empty());
  EXPECT_TRUE(std::ranges::all_of(found.of_surfel, [](int m) { return m < 0; }));
}

TEST(Metals, ReflectanceMeansTheSameInBothBlends) {
  for (const LayerBlend blend : {LayerBlend::RtrGs, LayerBlend::Layered}) {
    float k = 0.4f;
    Vec3f f0{0.3f, 0.35f, 0.4f};
    set_reflectance(blend, PolishedBall::kCopper, k, f0);
    const LayerWeights<float> w = layer_weights<float>(blend, {f0, k, 0, 1}, {.reflection = true});
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(w.reflection[c], PolishedBall::kCopper[c], 1e-5);
  }
}

}  // namespace
}  // namespace vitrine
