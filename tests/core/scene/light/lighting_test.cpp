#include "core/scene/light/lighting.h"

#include <cmath>
#include <numbers>

#include "tests/support/error_of.h"

namespace vitrine {
namespace {

TEST(Lamps, AFileHoldsAllKinds) {
  Lighting l;
  parse_lamps(
      "lights:\n"
      "  - {type: point, position: [0, 0, 2], intensity: [4, 4, 3]}\n"
      "  - {type: directional, from: [0, 0, 5], irradiance: 2}\n"
      "  - {type: rectangle, center: [1, 0, 2], facing: [0, 0, -1], size: [0.5, 0.2], radiance: 20}\n"
      "  - {type: disc, center: [0, 0, 2], facing: [0, 0, -2], radius: 0.5, radiance: [1, 2, 3]}\n",
      "x.yaml", l);
  ASSERT_EQ(l.lamps(), 4u);
  EXPECT_EQ(l.points[0].intensity, (Vec3f{4, 4, 3}));
  EXPECT_EQ(l.directionals[0].towards, (Vec3f{0, 0, 1}));
  EXPECT_EQ(l.directionals[0].irradiance, (Vec3f{2, 2, 2}));
  EXPECT_NEAR(l.areas[0].area(), 0.1, 1e-6);
  EXPECT_NEAR(l.areas[1].area(), 0.25 * std::numbers::pi, 1e-5);
  EXPECT_EQ(l.areas[1].normal, (Vec3f{0, 0, -1}));
  // Straight below: point 4 / 2^2; the disc shines down only.
  EXPECT_NEAR(l.sample_lamp(0, {0, 0, 0}, {}).radiance.x, 1, 1e-6);
  EXPECT_GT(l.sample_lamp(3, {0, 0, 0}, {0.3f, 0.4f}).pdf, 0);
  EXPECT_EQ(l.sample_lamp(3, {0, 0, 3}, {0.3f, 0.4f}).pdf, 0);
}

TEST(Lamps, AreaSamplesLieOnTheLightAndRaysMeetIt) {
  const AreaLight disc{
      .center = {0, 0, 2}, .normal = {0, 0, -1}, .half_u = {0.5f, 0, 0}, .half_v = {0, 0.5f, 0}, .radiance = {}, .disc = true};
  for (int i = 0; i < 50; ++i) {
    const Vec3f p = disc.point({float(i) / 50, float(i * 7 % 50) / 50});
    EXPECT_LE(length(p - disc.center), 0.5f + 1e-6f);
    const auto t = disc.hit({0, 0, 0}, normalized(p));
    ASSERT_TRUE(t.has_value());
    EXPECT_NEAR(*t, length(p), 1e-5);
  }
  EXPECT_FALSE(disc.hit({0, 0, 0}, normalized(Vec3f{0.4f, 0.4f, 2})).has_value());  // in the corner of its square
  EXPECT_FALSE(disc.hit({0, 0, 4}, {0, 0, -1}).has_value());                        // from behind
}

TEST(Lamps, KnowTheirPlaceAndWhetherTheyLightAnything) {
  Lighting l;
  parse_lamps(
      "lights:\n"
      "  - {type: disc, center: [0, 0, 2], facing: [0, 0, 1], radius: 0.5, radiance: 1}\n"
      "  - {type: point, position: [0, 0, 2], intensity: [0, 0, 0]}\n"
      "  - {type: rectangle, center: [0, 0, 2], facing: [0, 0, -1], size: [1, 1], radiance: 1}\n"
      "  - {type: directional, from: [0, 0, 1], irradiance: 0}\n"
      "  - {type: point, position: [0, 0, 2], intensity: [0, 0, 1]}\n",
      "x.yaml", l);
  EXPECT_EQ(l.places, (std::vector<std::string>{"x.yaml:3:5", "x.yaml:6:5", "x.yaml:5:5", "x.yaml:2:5", "x.yaml:4:5"}));
  const std::vector<Vec3f> floor{{0, 0, 0}, {3, 0, 0}}, ceiling{{0, 0, 3}};
  EXPECT_EQ(l.idle_reason(0, floor), "its intensity is 0");
  EXPECT_EQ(l.idle_reason(1, floor), "");
  EXPECT_EQ(l.idle_reason(2, floor), "its irradiance is 0");
  EXPECT_NE(l.idle_reason(3, floor).find("faces away"), std::string::npos);
  EXPECT_EQ(l.idle_reason(3, ceiling), "");
  EXPECT_EQ(l.idle_reason(4, floor), "");
  EXPECT_NE(l.idle_reason(4, ceiling).find("faces away"), std::string::npos);
}

TEST(Lamps, MistakesAreShownWithTheirLine) {
  const auto text_of = [](const char* lamp) {
    Lighting l;
    const Error e = error_of([&] { parse_lamps(std::string("lights:\n  - ") + lamp + "\n", "my.yaml", l); });
    EXPECT_EQ(e.kind(), ErrorKind::Usage);
    EXPECT_NE(std::string(e.what()).find("my.yaml:2:"), std::string::npos) << e.what();
    return std::string(e.what());
  };
  EXPECT_NE(text_of("{type: spot}").find("no light of type"), std::string::npos);
  EXPECT_NE(text_of("{position: [0, 0, 1]}").find("needs 'type'"), std::string::npos);
  EXPECT_NE(text_of("{type: point, position: [0, 0]}").find("three numbers"), std::string::npos);
  EXPECT_NE(text_of("{type: point, positoin: [0, 0, 0], intensity: 1}").find("did you mean 'position'"), std::string::npos);
  EXPECT_NE(text_of("{type: point, position: [0, 0, x], intensity: 1}").find("expected a number, got \"x\""), std::string::npos);
  EXPECT_NE(text_of("{type: directional, from: [0, 0, 0], irradiance: 1}").find("must not be zero"), std::string::npos);
  EXPECT_NE(text_of("{type: directional, from: [0, 0, 1], irradiance: -1}").find("must not be negative"), std::string::npos);
  EXPECT_NE(text_of("{type: disc, center: [0, 0, 0], facing: [0, 0, 1], radius: 0, radiance: 1}").find("above 0"),
            std::string::npos);
  EXPECT_NE(text_of("{type: point, position: [0, 0, 1]}").find("needs 'intensity'"), std::string::npos);
  Lighting l;
  const Error none = error_of([&] { parse_lamps("lights: []\n", "my.yaml", l); });
  EXPECT_EQ(none.kind(), ErrorKind::Usage);
  EXPECT_NE(std::string(none.what()).find("my.yaml:1:9: error: this list has no lamp"), std::string::npos) << none.what();
  EXPECT_EQ(error_of([&] { parse_lamps("", "empty.yaml", l); }).kind(), ErrorKind::Usage);
  EXPECT_EQ(error_of([&] { read_lamps("/nowhere/x.yaml", l); }).kind(), ErrorKind::Input);
}

}  // namespace
}  // namespace vitrine
