#include "stages/decompose/metals.h"

#include <algorithm>
#include <numbers>

#include <gtest/gtest.h>

#include "core/scene/light/environment.h"
#include "stages/decompose/light_solver.h"
#include "tests/support/tiny_capture.h"
#include "tests/support/written_objects.h"

namespace vitrine {
namespace {

// A polished ball under a light that is bright in two directions and dim between them.
class PolishedBall {
 public:
  static constexpr Vec3f kCopper{0.9f, 0.6f, 0.45f}, kPaint{0.12f, 0.2f, 0.3f};
  static constexpr uint16_t kBall = 3;

  // What a photo shows of the ball: `paint` + reflectance(cosine) * light of the mirrored direction.
  PolishedBall(const Vec3f& paint, const std::function<Vec3f(float cosine)>& reflectance) : environment(light()) {
    scene.surfels.diffuse = capture.layer;
    mesh = test::sphere_mesh(test::TinyCapture::kRadius);
    mesh.object_ids.assign(mesh.positions.size(), kBall);
    scene.surfels.diffuse.set_object_ids(std::vector<uint16_t>(scene.surfels.diffuse.size(), kBall));
    for (const View& v : capture.views) {
      const Intrinsics& k = v.intrinsics;
      ImageF photo(k.width, k.height, 3);
      const Vec3d eye = v.centre_in_world();
      for (int y = 0; y < k.height; ++y)
        for (int x = 0; x < k.width; ++x) {
          const Vec3d d = normalized(v.ray(x + 0.5, y + 0.5));
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
  // The ball as an object of this role, all pixels of all photos marked.
  Metals metals(ObjectRole role) const {
    const fs::path artifact = capture.sfm().parent_path() / "found";
    const ObjectSet set{.objects = {{.id = kBall, .name = "ball", .role = role}}, .shapes = {}};
    for (const View& v : capture.views) {
      const fs::path path = view_mask_path(artifact, MaskClass::Specular, v);
      make_folders(path.parent_path());
      write_ldr(path, Image8(v.intrinsics.width, v.intrinsics.height, 1, uint8_t(255)));
    }
    fs::remove_all(artifact / "objects");
    test::write_objects_artifact(artifact, artifact, capture.views, set);
    return metals(LabelledObjects::trusted(artifact));
  }
  Metals metals(const LabelledObjects& objects) const {
    return find_metals({.sfm_folder = capture.sfm(),
                        .scene = scene,
                        .mesh = mesh,
                        .views = capture.views,
                        .environment = environment,
                        .objects = objects});
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
  const Metals found = ball.metals(ObjectRole::Mirror);
  ASSERT_EQ(found.reflectors.size(), 1u);
  EXPECT_EQ(found.reflectors[0].object, 3);
  EXPECT_TRUE(found.reflectors[0].metal);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(found.reflectors[0].reflectance[c], PolishedBall::kCopper[c], 0.04);
  EXPECT_GT(std::ranges::count(found.of_surfel, 0), std::ptrdiff_t(found.of_surfel.size() * 2 / 3));
}

// Whatever it looks like: the table of objects decides.
TEST(Metals, TheRoleOfTheObjectDecides) {
  const PolishedBall copper({}, [](float) { return PolishedBall::kCopper; });
  EXPECT_TRUE(copper.metals(ObjectRole::Mirror).reflectors.at(0).metal);
  EXPECT_FALSE(copper.metals(ObjectRole::Coat).reflectors.at(0).metal);
}

TEST(Metals, SurfelsOfOtherObjectsKeepTheirMaterials) {
  PolishedBall ball({}, [](float) { return PolishedBall::kCopper; });
  std::vector<uint16_t> ids(ball.scene.surfels.diffuse.size(), PolishedBall::kBall);
  ids[1] = 0, ids[2] = PolishedBall::kBall + 1;
  ball.scene.surfels.diffuse.set_object_ids(ids);
  const Metals found = ball.metals(ObjectRole::Mirror);
  EXPECT_EQ(found.of_surfel[0], 0);
  EXPECT_EQ(found.of_surfel[1], -1);
  EXPECT_EQ(found.of_surfel[2], -1);
}

TEST(Metals, GlossIsTakenFromThePaintOfAGlaze) {
  const PolishedBall ball(PolishedBall::kPaint, [](float cosine) { return schlick(Vec3f{0.04f, 0.04f, 0.04f}, cosine).value; });
  const Metals found = ball.metals(ObjectRole::Coat);
  ASSERT_EQ(found.reflectors.size(), 1u);
  EXPECT_FALSE(found.reflectors[0].metal);
  // Over the ball's belt, which many views see: what the photos show in the mean, and what is left of it.
  Vec3d coat_light{};
  double count = 0;
  for (size_t i = 0; i < found.coat_light.size(); ++i)
    if (std::abs(ball.scene.surfels.diffuse.at(Attribute::Mean, i)[2]) < 0.2f)
      coat_light += cast<double>(found.coat_light[i]), count += 1;
  coat_light = coat_light / count;
  // 0.04 to 0.07 of a light whose mean is 0.45: within what the dimmer half of a handful of pixels leaves.
  EXPECT_GT(coat_light.x, 0.012);
  EXPECT_LT(coat_light.x, 0.045);
  EXPECT_NEAR(coat_light.z / coat_light.x, 0.8, 0.1);
}

TEST(Metals, MetalsLoseTheirPaintAndGlazesTheirGloss) {
  TrainedScene scene;
  scene.image.composite.blend = LayerBlend::Layered;
  Metals found;
  found.reflectors = {{.metal = true, .reflectance = PolishedBall::kCopper}, {.reflectance = {0.04f, 0.04f, 0.04f}}};
  found.of_surfel = {-1, 0, 1};
  found.coat_light = {{}, {}, {0.1f, 0.1f, 0.1f}};
  DecomposedMaterials materials;
  materials.resize(3);
  std::ranges::fill(materials.albedo, Vec3f{0.4f, 0.4f, 0.4f});
  apply_reflectors(found, scene, {{0.2f, 0.2f, 0.2f}, {0.2f, 0.2f, 0.2f}, {0.2f, 0.4f, 0.05f}}, materials);
  EXPECT_EQ(materials.albedo[0], (Vec3f{0.4f, 0.4f, 0.4f}));
  EXPECT_EQ(materials.albedo[1], Vec3f{});
  EXPECT_NEAR(materials.albedo[2].x, 0.2f, 1e-6);
  EXPECT_NEAR(materials.albedo[2].y, 0.3f, 1e-6);
  EXPECT_NEAR(materials.albedo[2].z, 0.04f, 1e-6);  // a tenth stays, however strong the light of the coat
  EXPECT_GT(materials.f0[1].x, 0.8f);
  EXPECT_LT(materials.f0[2].x, 0.05f);
}

TEST(Metals, WithoutMarksThereIsNone) {
  const PolishedBall ball({}, [](float) { return PolishedBall::kCopper; });
  const Metals found = ball.metals(LabelledObjects());
  EXPECT_TRUE(found.reflectors.empty());
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
