#include "core/scene/light/environment.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "tests/support/error_of.h"
#include "tests/support/exr_chromaticities.h"

namespace vitrine {
namespace {

constexpr double kPi = std::numbers::pi;

// Smooth, with one lamp of a few texels.
Environment lamp(int width = 64) {
  ImageF map(width, width / 2, 3);
  for (int y = 0; y < width / 2; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c)
        map.at(x, y, c) = 0.2f + 0.1f * float(c) * float(x) / float(width) + (x / 3 == 5 && y / 3 == 3 ? 40.f : 0.f);
  return Environment(std::move(map));
}

Vec3f on_sphere(Rng& rng) {
  const float z = 2 * rng.uniform() - 1, a = 2 * float(kPi) * rng.uniform(), s = std::sqrt(1 - z * z);
  return {s * std::cos(a), s * std::sin(a), z};
}

TEST(Environment, ChromaticitiesOfAnExrAreApplied) {
  TemporaryFolder folder;
  const fs::path path = folder.path() / "sky.exr";
  const Chromaticities rec2020{0.708, 0.292, 0.170, 0.797, 0.131, 0.046, 0.3127, 0.3290};
  ImageF map(16, 8, 3);
  for (size_t i = 0; i < map.pixel_count(); ++i)  // the colours of Rec. 709 red, and twice white
    for (size_t c = 0; c < 3; ++c) map.data()[3 * i + c] = i % 2 ? 2.f : (c == 0 ? 0.6274f : c == 1 ? 0.0691f : 0.0164f);
  write_exr_rgb(path, map, ExrPrecision::Float);
  test::add_chromaticities(path, rec2020);
  const ImageF read = read_environment(path).map();
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(read.at(0, 3, int(c)), c == 0 ? 1 : 0, 1e-3);  // ITU-R BT.2087
    EXPECT_NEAR(read.at(1, 3, int(c)), 2, 1e-4);
  }
}

TEST(Environment, IrradianceIsTheIntegralOverTheHemisphere) {
  const Environment grey(ImageF(64, 32, 3, 0.5f));
  for (const Vec3f& n : {Vec3f{0, 0, 1}, Vec3f{0, 0, -1}, normalized(Vec3f{1, -2, 0.3f})})
    EXPECT_NEAR(grey.irradiance(n).y, 0.5 * kPi, 0.5 * kPi * 0.003);  // worst seen 0.0012
  // Light from above alone: pi/2 (1 + cos) for a surface at that angle to up; none for one that faces down.
  ImageF sky(128, 64, 3);
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 128; ++x)
      for (int c = 0; c < 3; ++c) sky.at(x, y, c) = float(c);
  const Environment above(std::move(sky));
  for (const float cosine : {1.f, 0.5f, 0.f, -0.5f, -1.f}) {
    const Vec3f e = above.irradiance({0, std::sqrt(1 - cosine * cosine), cosine});
    EXPECT_EQ(e.x, 0);
    EXPECT_NEAR(e.y, kPi / 2 * (1 + double(cosine)), 0.004) << cosine;
    EXPECT_NEAR(e.z, 2 * e.y, 1e-5);
  }
  // Turned with the map.
  const Environment one = lamp();
  EXPECT_LT(length(one.rotated(90).irradiance({0, 1, 0}) - one.irradiance({1, 0, 0})), 1e-5f);
}

TEST(Environment, AxisProbeLandsWhereTheConventionsSay) {
  const Environment probe = axis_probe(128);
  const auto is = [&](const Environment& e, const Vec3f& d, const Vec3f& color) {
    EXPECT_LT(length(e.radiance(d) - color), 1e-6);
  };
  is(probe, {1, 0, 0}, {1, 0, 0});
  is(probe, {-1, 0, 0}, {0, 1, 1});
  is(probe, {0, 1, 0}, {0, 1, 0});
  is(probe, {0, -1, 0}, {1, 0, 1});
  is(probe, {0, 0, 1}, {0, 0, 1});
  is(probe, {0, 0, -1}, {1, 1, 0});
  const auto texel = [&](int x, int y) {
    return Vec3f{probe.map().at(x, y, 0), probe.map().at(x, y, 1), probe.map().at(x, y, 2)};
  };
  EXPECT_EQ(texel(64, 32), (Vec3f{1, 0, 0}));  // centre = +x
  EXPECT_EQ(texel(96, 32), (Vec3f{1, 0, 1}));  // three quarters = -y
  EXPECT_EQ(texel(10, 0), (Vec3f{0, 0, 1}));   // first row = up
  // A quarter turn takes the light of +x to +y.
  is(probe.rotated(90), {0, 1, 0}, {1, 0, 0});
  is(probe.rotated(-90), {0, -1, 0}, {1, 0, 0});
}

TEST(Environment, CoordinatesAndDirectionsAreInverse) {
  Rng rng(1);
  for (int i = 0; i < 1000; ++i) {
    const Vec3f d = on_sphere(rng);
    const Vec2f uv = lat_long_coordinates(d);
    EXPECT_LT(length(lat_long_direction(uv.x, uv.y) - d), 1e-5);
  }
}

TEST(Environment, AWholeTurnIsTheIdentity) {
  const Environment a = lamp(), b = a.rotated(360), c = a.rotated(-720);
  Rng rng(2);
  for (int i = 0; i < 200; ++i) {
    const Vec3f d = on_sphere(rng);
    const Vec2f u{rng.uniform(), rng.uniform()};
    EXPECT_EQ(a.radiance(d), b.radiance(d));
    EXPECT_EQ(a.radiance(d), c.radiance(d));
    EXPECT_EQ(a.sample(u).direction, b.sample(u).direction);
  }
}

TEST(Environment, DensityIntegratesToOneAndSamplesFollowIt) {
  const Environment e = lamp().rotated(30);
  Rng rng(3);
  double integral = 0;
  const int n = 200000;
  for (int i = 0; i < n; ++i) integral += e.pdf(on_sphere(rng)) * 4 * kPi / n;
  EXPECT_NEAR(integral, 1, 0.03);
  // The mean of radiance / pdf is the integral of the radiance, whatever the light; mean() knows it exactly.
  Vec3d sum{};
  double squares = 0, even_squares = 0;
  for (int i = 0; i < 20000; ++i) {
    const Environment::Sample s = e.sample({rng.uniform(), rng.uniform()});
    ASSERT_GT(s.pdf, 0);
    EXPECT_NEAR(length(s.direction), 1, 1e-5);
    EXPECT_NEAR(e.pdf(s.direction) / s.pdf, 1, 0.9) << "only at an edge of a texel may rounding choose its neighbour";
    sum += cast<double>(s.radiance / s.pdf) / 20000.0;
    squares += std::pow(s.radiance.y / s.pdf, 2) / 20000;
    even_squares += std::pow(e.radiance(on_sphere(rng)).y * 4 * kPi, 2) / 20000;
  }
  for (size_t c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / (4 * kPi * e.mean()[c]), 1, 0.02);
  // Far less spread than with directions drawn evenly.
  const double mean2 = std::pow(4 * kPi * e.mean().y, 2);
  EXPECT_LT(squares - mean2, 0.05 * (even_squares - mean2));
}

TEST(Environment, ConstantLightIsConstant) {
  const Environment e(ImageF(8, 4, 3, 0.7f));
  EXPECT_NEAR(e.mean().x, 0.7f, 1e-6);
  EXPECT_NEAR(e.pdf({0, 0, 1}), 1 / (4 * kPi), 1e-6);
  EXPECT_NEAR(e.sample({0.3f, 0.6f}).pdf, 1 / (4 * kPi), 1e-6);
  EXPECT_TRUE(Environment().black());
  EXPECT_TRUE(Environment(ImageF(8, 4, 3, 0.f)).black());
  EXPECT_EQ(Environment(ImageF(8, 4, 3, 0.f)).sample({0.5f, 0.5f}).pdf, 0);
}

TEST(Environment, IsReadBackAsWritten) {
  const TemporaryFolder folder;
  write_environment(folder.path() / "a.exr", lamp());
  EXPECT_EQ(read_environment(folder.path() / "a.exr").map(), lamp().map());
}

// --- Radiance HDR ------------------------------------------------------------------------------------------------------

std::string header(int w, int h) { return fmt::format("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", h, w); }

TEST(RadianceHdr, FlatOldAndNewRunsGiveTheSamePicture) {
  const int w = 8, h = 4;
  std::string flat = header(w, h), old = header(w, h), coded = header(w, h);
  for (int y = 0; y < h; ++y) {
    const char e = char(129 + y);
    for (int x = 0; x < w; ++x) flat += {char(128), char(64), char(y), e};
    old += {char(128), char(64), char(y), e, 1, 1, 1, char(w - 1)};
    coded += {2, 2, 0, char(w)};
    coded += {char(128 + w), char(128)};
    coded += {char(128 + w), char(64)};
    coded += {3, char(y), char(y), char(y), char(128 + 5), char(y)};
    coded += {char(128 + w), e};
  }
  const ImageF a = parse_radiance_hdr(flat, "a.hdr");
  EXPECT_EQ(a.at(0, 0, 0), 1.f);  // 128 * 2^(129-136)
  EXPECT_EQ(a.at(7, 3, 1), 4.f);
  EXPECT_EQ(a.at(7, 3, 2), 3.f / 16);
  EXPECT_EQ(parse_radiance_hdr(old, "b.hdr"), a);
  EXPECT_EQ(parse_radiance_hdr(coded, "c.hdr"), a);
  const TemporaryFolder folder;
  write_file(folder.path() / "sky.pic", coded);
  EXPECT_EQ(read_environment(folder.path() / "sky.pic").map(), a);
  for (const std::string& whole : {flat, old, coded})  // cut anywhere: an error, never a crash
    for (size_t n = 0; n < whole.size(); n += 3)
      EXPECT_EQ(error_of([&] { parse_radiance_hdr(std::string_view(whole).substr(0, n), "cut.hdr"); }).detail().code, "BAD_HDR");
}

TEST(RadianceHdr, DamageIsNamed) {
  const auto why = [](const std::string& text) { return error_of([&] { parse_radiance_hdr(text, "x.hdr"); }).detail().why; };
  EXPECT_NE(why("#?RADIANCE\nFORMAT=32-bit_rle_cmyk\n\n-Y 4 +X 8\n").find("cmyk"), std::string::npos);
  EXPECT_NE(why("#?RADIANCE\nEXPOSURE=0\n\n-Y 4 +X 8\n").find("EXPOSURE=0"), std::string::npos);
  EXPECT_NE(why("#?RADIANCE\nCOLORCORR=1 1\n\n-Y 4 +X 8\n").find("too few"), std::string::npos);
  for (const char* size : {"+Y 4 +Y 8", "-Y 4", "Y 4 X 8", "-Y 4+X 8", "-Y 0 +X 8", "-Y 4 +X 8 +Z 2"})
    EXPECT_NE(why(fmt::format("#?RADIANCE\n\n{}\n", size)).find("its size"), std::string::npos) << size;
  EXPECT_NE(why("#?RADIANCE\n\n-Y 99999 +X 99999\n").find("plausible"), std::string::npos);
  EXPECT_NE(why(header(8, 1) + std::string({2, 2, 0, 8, char(255), 0})).find("leaves its scanline"), std::string::npos);
  EXPECT_NE(why(header(8, 1) + std::string({1, 1, 1, 7, 1, 1, 1, 7})).find("leaves its scanline"), std::string::npos);
}

// 2 rows of 4 columns; the value of a pixel is its place.
std::string numbered(const std::string& lines, const std::string& size, const std::vector<int>& order) {
  std::string text = "#?RADIANCE\n" + lines + "\n" + size + "\n";
  for (const int i : order) text += {char(10 * i + 1), char(10 * i + 2), char(10 * i + 3), char(136)};
  return text;
}

TEST(RadianceHdr, ExposuresAndCorrectionsOfAllLinesAreDividedOut) {
  const std::vector<int> order{0, 1, 2, 3, 4, 5, 6, 7};
  std::vector<std::string> notes;
  const ImageF plain = parse_radiance_hdr(numbered("EXPOSURE=1\n", "-Y 2 +X 4", order), "a.hdr", &notes);
  EXPECT_TRUE(notes.empty());
  EXPECT_EQ(plain.at(1, 1, 2), 53.f);
  const ImageF scaled = parse_radiance_hdr(
      numbered("EXPOSURE=4\nVIEW= -vta\nEXPOSURE= 5.000000e-01\nCOLORCORR= 1 2.0 4\n", "-Y 2 +X 4", order), "a.hdr", &notes);
  for (size_t i = 0; i < plain.data().size(); ++i) EXPECT_FLOAT_EQ(scaled.data()[i] * float(2 << i % 3), plain.data()[i]);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_EQ(notes[0], "its values are divided by EXPOSURE and COLORCORR (2, 4, 8)");
  notes.clear();
  parse_radiance_hdr(numbered("PRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.329\n", "-Y 2 +X 4", order), "a.hdr",
                     &notes);
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].find("are not those of sRGB"), std::string::npos);
  notes.clear();
  parse_radiance_hdr(numbered("PRIMARIES=0.640 0.330 0.290 0.600 0.150 0.060 0.333 0.333\n", "-Y 2 +X 4", order), "a.hdr",
                     &notes);
  EXPECT_TRUE(notes.empty());
}

TEST(RadianceHdr, AllEightOrdersOfPixelsGiveTheSamePicture) {
  const std::pair<const char*, std::vector<int>> orders[] = {
      {"-Y 2 +X 4", {0, 1, 2, 3, 4, 5, 6, 7}}, {"-Y 2 -X 4", {3, 2, 1, 0, 7, 6, 5, 4}}, {"+Y 2 +X 4", {4, 5, 6, 7, 0, 1, 2, 3}},
      {"+Y 2 -X 4", {7, 6, 5, 4, 3, 2, 1, 0}}, {"+X 4 -Y 2", {0, 4, 1, 5, 2, 6, 3, 7}}, {"-X 4 -Y 2", {3, 7, 2, 6, 1, 5, 0, 4}},
      {"+X 4 +Y 2", {4, 0, 5, 1, 6, 2, 7, 3}}, {"-X 4 +Y 2", {7, 3, 6, 2, 5, 1, 4, 0}}};
  const ImageF plain = parse_radiance_hdr(numbered("", orders[0].first, orders[0].second), "a.hdr");
  for (const auto& [size, order] : orders) EXPECT_EQ(parse_radiance_hdr(numbered("", size, order), "a.hdr"), plain) << size;
}

TEST(RadianceHdr, XyzBecomesRgbAndGreyStaysGrey) {
  std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 2\n";
  text += {char(128), char(128), char(128), char(129)};
  text += {char(64), char(33), char(3), char(136)};  // the direction of red
  std::vector<std::string> notes;
  const ImageF rgb = parse_radiance_hdr(text, "a.hdr", &notes);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb.at(0, 0, c), 1, 1e-6);
  EXPECT_GT(rgb.at(1, 0, 0), 50);
  for (int c = 1; c < 3; ++c) EXPECT_NEAR(rgb.at(1, 0, c), 0, 1e-3);
  EXPECT_EQ(notes.size(), 1u);
}

// --- bad maps ----------------------------------------------------------------------------------------------------------

TEST(EnvironmentFile, WhatCannotLightASceneIsRefusedWithItsReason) {
  const TemporaryFolder folder;
  const auto code = [&](const char* file) {
    const Error e = error_of([&] { read_environment(folder.path() / file); });
    EXPECT_EQ(e.kind(), ErrorKind::Input);
    EXPECT_NE(std::string(e.what()).find(file), std::string::npos) << e.what();
    EXPECT_FALSE(e.detail().hint.empty());
    return e.detail().code;
  };
  write_ldr(folder.path() / "sky.png", Image8(8, 4, 3));
  write_ldr(folder.path() / "sky.jpg", Image8(8, 4, 3));
  fs::copy_file(folder.path() / "sky.png", folder.path() / "named.exr");
  EXPECT_EQ(code("sky.png"), "ENV_LDR");
  EXPECT_EQ(code("sky.jpg"), "ENV_LDR");
  EXPECT_EQ(code("named.exr"), "ENV_LDR");
  write_exr_rgb(folder.path() / "square.exr", ImageF(8, 8, 3));
  EXPECT_EQ(code("square.exr"), "ENV_SHAPE");
  EXPECT_EQ(code("none.exr"), "MISSING_INPUT");
  write_file(folder.path() / "text.hdr", "hello");
  EXPECT_EQ(code("text.hdr"), "ENV_FORMAT");
  write_file(folder.path() / "empty.hdr", "");
  EXPECT_EQ(code("empty.hdr"), "ENV_FORMAT");
  write_file(folder.path() / "cut.exr", std::string("\x76\x2f\x31\x01 and no more"));
  EXPECT_EQ(code("cut.exr"), "BAD_EXR");
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    ImageF map(8, 4, 3, 1.f);
    map.at(5, 2, 1) = bad;
    write_exr_rgb(folder.path() / "bad.exr", map, ExrPrecision::Float);
    EXPECT_EQ(code("bad.exr"), "ENV_BAD_TEXELS");
    const std::string text = error_of([&] { read_environment(folder.path() / "bad.exr"); }).what();
    EXPECT_NE(text.find("column 5, row 2"), std::string::npos) << text;
    EXPECT_NE(text.find(std::isnan(bad) ? "1 NaN" : "1 infinite"), std::string::npos) << text;
  }
}

TEST(EnvironmentFile, WhatIsDarkerThanBlackIsBlackAndCounted) {
  const TemporaryFolder folder;
  ImageF map(8, 4, 3, 1.f);
  for (const auto& [x, y, c] : {std::array{5, 2, 1}, {5, 2, 2}, {0, 0, 0}}) map.at(x, y, c) = -0.5f;
  write_exr_rgb(folder.path() / "rings.exr", map, ExrPrecision::Float);
  size_t negative = 0;
  const Environment read = read_environment(folder.path() / "rings.exr", &negative);
  EXPECT_EQ(negative, 2u);
  for (float& v : map.data()) v = std::max(v, 0.f);
  EXPECT_EQ(read.map(), map);
  write_exr_rgb(folder.path() / "fine.exr", map, ExrPrecision::Float);
  EXPECT_EQ(read_environment(folder.path() / "fine.exr", &negative).map(), map);
  EXPECT_EQ(negative, 0u);
}

}  // namespace
}  // namespace vitrine
