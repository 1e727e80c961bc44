// What fills bodies of glass: closed forms along rays, light and shadows of a filled body, and the truth next to the photos.
#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"
#include "core/render/volume/reference/reference.h"
#include "core/scene/image/ldr.h"
#include "sample_data/generate/content.h"
#include "sample_data/generate/integrator.h"
#include "sample_data/generate/scenes/scenes.h"
#include "sample_data/generate/truth.h"

namespace vitrine::generate {
namespace {

GlassContent some_smoke() {
  const Scene scene = scene_named("smoky");
  for (const Part& part : scene.parts)
    if (part.material.content) return {0, {}, part.material.content->clouds()};
  throw std::runtime_error("no part is filled");
}

TEST(GlassContent, OfOneDensityIsBeersLaw) {
  const GlassContent liquid(3, {0.4f, 0.6f, 0.2f}, {});
  const VolumeLightf light = liquid.light({1, 2, 3}, {0, 0, 1}, 0.5f);
  const double passed = std::exp(-1.5);
  EXPECT_NEAR(double(light.transmittance), passed, 1e-5);
  EXPECT_NEAR(double(liquid.transmittance({1, 2, 3}, {0, 0, 1}, 0.5f)), passed, 1e-6);
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(double(light.color[c]), double(liquid.color()[c]) * (1 - passed), 1e-5);
}

TEST(GlassContent, OfCloudsIsTheReferenceOfVolumes) {
  const GlassContent smoke = some_smoke();
  std::vector<Gaussian3d> gaussians;
  std::vector<Vec3d> colors;
  for (const auto& cloud : smoke.clouds())
    gaussians.push_back(cast<double>(cloud.gaussian)), colors.push_back(cast<double>(cloud.color));
  double least = 1;
  for (int i = 0; i < 12; ++i) {
    const Vec3d target{0.02 * i - 0.12, 0.03, 0.15 + 0.025 * i}, origin{-1, 0.2, 0.3};
    const VolumeRay ray{origin, normalized(target - origin)};
    const VolumeLightd truth = reference_emission({gaussians, colors}, std::span(&ray, 1))[0];
    const Vec3f start = cast<float>(origin), direction = cast<float>(ray.direction);
    const VolumeLightf light = smoke.light(start, direction, 2);
    EXPECT_LT(length(cast<double>(light.color) - truth.color), 3e-3) << i;
    EXPECT_NEAR(double(light.transmittance), truth.transmittance, 1e-4) << i;
    const VolumeLightf front = smoke.light(start, direction, 1), back = smoke.light(start + direction, direction, 1);
    EXPECT_LT(length(front.color + front.transmittance * back.color - cast<float>(truth.color)), 3e-3f) << i;
    EXPECT_NEAR(double(smoke.transmittance(start, direction, 1)), double(front.transmittance), 1e-5) << i;
    least = std::min(least, truth.transmittance);
  }
  EXPECT_LT(least, 0.5) << "rays miss the smoke";
}

// A block that bends and reflects nothing, one metre thick, in front of an even sky.
TEST(GlassContent, FillsTheBodyAndWeakensShadowRays) {
  const float density = 1.2f;
  Scene scene;
  scene.parts.push_back({.name = "block",
                         .shape = box({-2, -2, 0}, {2, 2, 1}, 1),
                         .material = {.kind = MaterialKind::SolidGlass,
                                      .index_of_refraction = 1,
                                      .content = std::make_shared<const GlassContent>(density, Vec3f{0.1f, 0.2f, 0.3f},
                                                                                      std::vector<GlassContent::Cloud>{})}});
  scene.environment = Environment(ImageF(16, 8, 3, 1.0f));
  const RayScene rays(scene);
  const Integrator integrator(rays, {.environment = scene.environment, .lamps = {}});
  const Integrator without_glass(rays, {.environment = scene.environment, .lamps = {}, .glass = false});
  for (const float cosine : {1.0f, 0.7f}) {
    Sampler sampler(5, 0);
    const Vec3f down{std::sqrt(1 - cosine * cosine), 0, -cosine}, eye = Vec3f{0, 0, 0.5f} - 3.0f * down;
    const double passed = std::exp(-double(density) / double(cosine));
    const Vec3f seen = integrator.radiance(eye, down, nullptr, sampler);
    for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(double(seen[c]), passed + 0.1 * double(c + 1) * (1 - passed), 1e-3) << cosine;
    EXPECT_NEAR(double(rays.transmittance(eye, down, 10)), passed, 1e-3);
    EXPECT_NEAR(double(rays.transmittance({0, 0, 0.5f}, down, 10)), std::sqrt(passed), 1e-3) << "from within";
    EXPECT_NEAR(double(without_glass.radiance(eye, down, nullptr, sampler).x), 1, 1e-3);
  }
}

TEST(GlassContent, TruthNamesTheContentAndPhotosShowIt) {
  for (const char* name : {"cloudy", "smoky"}) {
    Scene scene = scene_named(name);
    scene.views.resize(1);
    resize_views(scene, 48, 36);
    const CacheDesc quick{.direct_samples = 2, .gather_samples = 1, .passes = 0};
    scene.cache = quick;
    const TemporaryFolder folder;
    generate(scene, folder.path(), {.photos = false, .relit = false, .samples = 2});
    const auto json = nlohmann::json::parse(read_file(folder.path() / "truth" / "content.json"));
    ASSERT_EQ(json.size(), 1u);
    EXPECT_EQ(json[0].at("part"), "ball");
    const Part* filled = nullptr;
    for (const Part& part : scene.parts)
      if (part.material.content) filled = &part;
    ASSERT_NE(filled, nullptr);
    const GlassContent& content = *filled->material.content;
    EXPECT_FLOAT_EQ(json[0].at("density_per_m").get<float>(), content.density());
    ASSERT_EQ(json[0].at("clouds").size(), content.clouds().size());
    for (size_t i = 0; i < content.clouds().size(); ++i) {
      const auto& cloud = json[0].at("clouds")[i];
      EXPECT_FLOAT_EQ(cloud.at("mean")[2].get<float>(), content.clouds()[i].gaussian.mean.z);
      EXPECT_FLOAT_EQ(cloud.at("density_per_m").get<float>(), std::exp(content.clouds()[i].gaussian.log_density));
    }
    Scene clear = scene;
    for (Part& part : clear.parts) part.material.content = nullptr;
    const Image8 a = photograph(scene, 0, 2, quick), b = photograph(clear, 0, 2, quick);
    double difference = 0;
    for (size_t i = 0; i < a.data().size(); ++i) difference += std::abs(double(a.data()[i]) - double(b.data()[i]));
    EXPECT_GT(difference / double(a.data().size()), 4) << name;
  }
}

}  // namespace
}  // namespace vitrine::generate
