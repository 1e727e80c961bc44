// Water and haze before the cameras of generated scenes: the formula, its distances, and the truth next to the photos.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/config/json_file.h"
#include "core/foundation/math/color.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "sample_data/generate/capture.h"
#include "sample_data/generate/scenes/scenes.h"
#include "sample_data/generate/truth.h"

namespace vitrine::generate {
namespace {

TEST(Medium, IsTheSceneUpCloseAndTheVeilFarAway) {
  for (const Medium& medium : medium_list()) {
    const Vec3f radiance{0.8f, 0.3f, 0.1f};
    EXPECT_EQ(medium.seen(radiance, 0), radiance) << medium.name;
    EXPECT_EQ(medium.seen(radiance, std::numeric_limits<float>::infinity()), medium.veil) << medium.name;
    const Vec3f seen = medium.seen(radiance, 1.5f);
    for (size_t c = 0; c < 3; ++c) {
      const double direct = std::exp(-1.5 * double(medium.direct[c])), back = std::exp(-1.5 * double(medium.backscatter[c]));
      EXPECT_NEAR(double(seen[c]), direct * double(radiance[c]) + (1 - back) * double(medium.veil[c]), 1e-6) << medium.name;
    }
  }
  const Medium haze = medium_named("haze");
  EXPECT_EQ(haze.direct, haze.backscatter);
  EXPECT_EQ(haze.direct.x, haze.direct.z);
}

TEST(Medium, ActsOnTheDistanceAlongTheRay) {
  Scene scene;  // a plate that mirrors an even sky, two metres below the eye
  scene.parts.push_back({.name = "plate",
                         .shape = rectangle({-50, -50, 0}, {100, 0, 0}, {0, 100, 0}, 200),
                         .material = {.kind = MaterialKind::Mirror, .reflectance = {1, 1, 1}}});
  scene.environment = Environment(ImageF(16, 8, 3, 1.0f));
  const Medium water = medium_named("coastal");
  const RayScene rays(scene);
  const Integrator integrator(rays, {.environment = scene.environment, .lamps = {}, .medium = &water});
  for (const float cosine : {1.0f, 0.5f}) {
    Sampler sampler(5, 0);
    const Vec3f down{std::sqrt(1 - cosine * cosine), 0, -cosine};
    const Vec3f seen = integrator.radiance({0, 0, 2}, down, nullptr, sampler);
    for (size_t c = 0; c < 3; ++c) {
      const double z = 2 / double(cosine), direct = double(water.direct[c]), back = double(water.backscatter[c]);
      EXPECT_NEAR(double(seen[c]), std::exp(-direct * z) + double(water.veil[c]) * (1 - std::exp(-back * z)), 1e-4);
    }
  }
  Sampler sampler(5, 0);
  EXPECT_EQ(integrator.radiance({0, 0, 2}, {0, 0, 1}, nullptr, sampler), water.veil);
}

TEST(Medium, TruthHoldsTheSceneInAirAndTheCoefficients) {
  Scene scene = scene_named("tiny_room");
  scene.views.resize(1);
  resize_views(scene, 48, 32);
  scene.cache = {.direct_samples = 8, .gather_samples = 4, .passes = 1};
  scene.sensor.shot_noise = scene.sensor.read_noise = 0;
  scene.medium = medium_named("green");
  const TemporaryFolder folder;
  generate(scene, folder.path(), {.relit = false, .samples = 2});
  const fs::path truth = folder.path() / "truth";
  const auto json = nlohmann::json::parse(read_file(truth / "medium.json"));
  EXPECT_EQ(json.at("medium"), "green");
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_FLOAT_EQ(json.at("direct_per_m")[c].get<float>(), scene.medium->direct[c]);
    EXPECT_FLOAT_EQ(json.at("backscatter_per_m")[c].get<float>(), scene.medium->backscatter[c]);
    EXPECT_FLOAT_EQ(json.at("veil")[c].get<float>(), scene.medium->veil[c]);
  }
  const View& view = scene.views[0];
  const ImageF clear = read_exr(truth / "clear" / (view.stem() + ".exr")).pixels,
               depth = read_exr(truth / "depth" / (view.stem() + ".exr")).pixels;
  const Image8 photo = read_srgb8(folder.path() / "photos" / view.name);
  ASSERT_EQ(clear.width(), photo.width());
  double error = 0, in_air = 0;
  for (int y = 0; y < photo.height(); ++y)
    for (int x = 0; x < photo.width(); ++x) {
      const float z = depth.at(x, y) * static_cast<float>(length(view.intrinsics.ray(x + 0.5, y + 0.5)));
      const Vec3f air{clear.at(x, y, 0), clear.at(x, y, 1), clear.at(x, y, 2)}, seen = scene.medium->seen(air, z);
      for (size_t c = 0; c < 3; ++c) {
        const float shown = float(photo.at(x, y, int(c))) / 255.f;
        error += std::abs(double(shown - srgb_from_linear(std::min(seen[c], 1.f))));
        in_air += std::abs(double(shown - srgb_from_linear(std::min(air[c], 1.f))));
      }
    }
  const double values = 3.0 * double(photo.pixel_count());
  EXPECT_LT(error / values, 0.01);
  EXPECT_GT(in_air / values, 0.05);
}

TEST(Medium, UnknownNamesAreRefusedWithTheKnownOnes) {
  try {
    medium_named("mud");
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::Usage);
    EXPECT_NE(error.detail().hint.find("coastal, deep, green, haze"), std::string::npos);
  }
}

}  // namespace
}  // namespace vitrine::generate
