// Lamps in the page of `vitrine view`, in headless Chromium: what they light and what lies in their shadow, and the files that
// they are saved as, for `vitrine relight`.
#include <gtest/gtest.h>

#include "core/foundation/base/json.h"
#include "core/scene/image/metrics.h"
#include "core/scene/light/lighting.h"
#include "core/render/relight/relit_painter.h"
#include "stages/page_text.h"
#include "stages/view/view.h"
#include "tests/pages/in_chromium.h"
#include "tests/stages/edit/two_balls.h"
#include "tests/support/recording_context.h"

namespace vitrine {
namespace {

using nlohmann::json;

// Of a surface that faces `normal`, without anything before it.
Vec3d irradiance_of_map(const Environment& environment, const Vec3f& normal) {
  const ImageF& map = environment.map();
  Vec3d sum{};
  for (int y = 0; y < map.height(); ++y)
    for (int x = 0; x < map.width(); ++x) {
      const Vec3f d = lat_long_direction((float(x) + 0.5f) / float(map.width()), (float(y) + 0.5f) / float(map.height()));
      const double share = texel_solid_angle(y, map.width(), map.height()) * std::max(0.f, dot(normal, d));
      for (size_t c = 0; c < 3; ++c) sum[c] += share * double(map.pixel(x, y)[c]);
    }
  return sum;
}
Vec3d irradiance_of_lamp(const Lighting& lighting, const Vec3f& normal) {
  constexpr int kSide = 16;
  Vec3d sum{};
  for (int k = 0; k < kSide * kSide; ++k) {
    const LampSample s = lighting.sample_lamp(0, {}, {(float(k % kSide) + 0.5f) / kSide, (float(k / kSide) + 0.5f) / kSide});
    if (s.pdf > 0) sum += cast<double>(std::max(0.f, dot(normal, s.direction)) / (s.pdf * kSide * kSide) * s.radiance);
  }
  return sum;
}

using ViewLamps = InChromium;

TEST_F(ViewLamps, ThrowShadowsAndAreSavedForRelight) {
  const test::TwoBalls balls;
  test::RecordingContext context(balls.artifacts());
  write_view(read_file(fs::path(VITRINE_BIN_DIR) / empty_page_path("view").filename()), {}, context);
  // Both points face -x and -y; seen from -x the first ball stands before the second.
  constexpr double kSlant = 0.7071;
  json points = json::array();
  for (const auto& [middle, radius] : {std::pair{balls.kA, balls.kRadiusA}, std::pair{balls.kB, balls.kRadiusB}})
    points.push_back({middle.x - kSlant * radius, middle.y - kSlant * radius, middle.z});
  constexpr size_t kCamera = 6;  // at -y
  const fs::path out = pictures("view_lamps");
  const Said said = run_script(
      {"view_lamps.mjs", (context.output() / "view.html").string(), std::to_string(kCamera), points.dump(), out.string()});
  const json r = answer(said);
  ASSERT_FALSE(r.empty());
  EXPECT_TRUE(r["messages"].empty()) << r["messages"];

  EXPECT_EQ(r["placed"]["azimuth"], -180);
  EXPECT_EQ(r["placed"]["elevation"], 0);
  EXPECT_GT(r["behind"][0], 60) << "lit";
  EXPECT_LT(r["behind"][1].get<double>(), 0.4 * r["behind"][0].get<double>()) << "in the shadow of the first ball";
  EXPECT_GT(r["aside"][0], 60);
  EXPECT_GT(r["aside"][1].get<double>(), 2.5 * r["behind"][1].get<double>()) << "the lamp stands where both see it";
  EXPECT_LT(r["off"][0], 5) << "no lamp, and a black sky";
  EXPECT_NE(r["dragged"]["azimuth"], r["placed"]["azimuth"]);
  EXPECT_GT(r["dragged"]["elevation"], 5);
  EXPECT_TRUE(r["eye"]) << "the drag moved the lamp, not the camera";
  EXPECT_EQ(r["removed"], 0);
  EXPECT_TRUE(r["turned"]) << "without a lamp the drag turns the scene";
  EXPECT_EQ(r["reopened"][0]["azimuth"], -144);
  EXPECT_EQ(r["reopened"][1], 0);
  EXPECT_NEAR(r["again"][1].get<double>() / r["again"][0].get<double>(), 1, 0.01);

  // The files give the light of the page: of a white lamp, two times the irradiance under the light of the photos, which is 1
  // everywhere.
  const double azimuth = -144 * std::numbers::pi / 180;
  const Vec3f towards{float(std::cos(azimuth)), float(std::sin(azimuth)), 0};
  Lighting sky, lamps;
  sky.environment = read_environment(out / "light.hdr");
  read_lamps(out / "lamps.yaml", lamps);
  ASSERT_EQ(lamps.areas.size(), 1u);
  for (const Vec3f& normal : {towards, normalized(towards + Vec3f{0, 0, 1}), -1.f * towards}) {
    const double wanted = 2 * std::numbers::pi * std::max(0.f, dot(normal, towards));
    const Vec3d of_map = irradiance_of_map(sky.environment, normal), of_lamp = irradiance_of_lamp(lamps, normal);
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(of_map[c], wanted, 0.02 * 2 * std::numbers::pi);
      EXPECT_NEAR(of_lamp[c], wanted, 0.02 * 2 * std::numbers::pi);
    }
  }
  // And the picture: the page has softer shadows.
  RelitPainter painter(
      read_relit_scene({.optimize = balls.capture.optimize(), .mesh = balls.capture.mesh(), .decompose = balls.decompose()}));
  painter.set_lighting(sky);
  EXPECT_GT(psnr(srgb_from_linear_image(painter.picture(balls.capture.views[kCamera]).radiance), read_srgb(out / "lamp.png")),
            22);
}

}  // namespace
}  // namespace vitrine
