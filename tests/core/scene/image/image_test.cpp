#include <cmath>

#include <gtest/gtest.h>

#include "core/foundation/base/error.h"
#include "core/foundation/base/file.h"
#include "core/foundation/base/rng.h"
#include "core/scene/image/exr.h"
#include "core/scene/image/ldr.h"
#include "core/scene/image/metrics.h"
#include "core/scene/image/resample.h"

namespace vitrine {
namespace {

ImageF noise(int width, int height, int channels, uint64_t seed) {
  Rng rng(seed);
  ImageF image(width, height, channels);
  for (float& v : image.data()) v = rng.uniform();
  return image;
}

TEST(Exr, FloatChannelsRoundTripExactlyWithTheirNamesAndAttributes) {
  const TemporaryFolder folder;
  const ExrImage written{noise(17, 9, 4, 1), {"normal.x", "normal.y", "normal.z", "zdepth"}, {{"vitrine:stage", "sfm"}}};
  write_exr(folder.path() / "ä b.exr", written, ExrPrecision::Float);
  const ExrImage read = read_exr(folder.path() / "ä b.exr");
  ASSERT_EQ(read.channels.size(), 4u);
  EXPECT_EQ(read.attributes.at("vitrine:stage"), "sfm");
  for (size_t c = 0; c < 4; ++c) {
    const auto it = std::find(written.channels.begin(), written.channels.end(), read.channels[c]);
    ASSERT_NE(it, written.channels.end());
    const int source = int(it - written.channels.begin());
    for (int y = 0; y < 9; ++y)
      for (int x = 0; x < 17; ++x) EXPECT_EQ(read.pixels.at(x, y, int(c)), written.pixels.at(x, y, source));
  }
}

TEST(Exr, RgbComesBackInRgbOrder) {
  const TemporaryFolder folder;
  const ImageF rgb = noise(8, 5, 3, 2);
  write_exr_rgb(folder.path() / "a.exr", rgb, ExrPrecision::Float);
  EXPECT_EQ(read_exr_rgb(folder.path() / "a.exr"), rgb);
  EXPECT_EQ(read_exr(folder.path() / "a.exr").channels, (std::vector<std::string>{"R", "G", "B"}));
}

TEST(Exr, EveryTruncationIsANamedErrorOrAPicture) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "a.exr";
  write_exr_rgb(path, noise(16, 16, 3, 3));
  const std::string bytes = read_file(path);
  int errors = 0;
  for (size_t n = 0; n < bytes.size(); n += 37) {
    write_file(path, std::string_view(bytes).substr(0, n));
    try {
      read_exr(path);
    } catch (const Error& e) {
      ++errors;
      EXPECT_EQ(e.kind(), ErrorKind::Input);
      EXPECT_NE(std::string(e.what()).find("a.exr"), std::string::npos);
    }
  }
  EXPECT_GT(errors, 10);
}

TEST(Ldr, PngRoundTripsAndBadFilesSayWhy) {
  const TemporaryFolder folder;
  Image8 image(13, 7, 3);
  Rng rng(4);
  for (uint8_t& v : image.data()) v = uint8_t(rng.below(256));
  write_ldr(folder.path() / "é.png", image);
  const ImageF back = read_srgb(folder.path() / "é.png");
  for (size_t i = 0; i < image.data().size(); ++i) EXPECT_FLOAT_EQ(back.data()[i] * 255.f, image.data()[i]);
  write_file(folder.path() / "empty.jpg", "");
  try {
    read_srgb(folder.path() / "empty.jpg");
    FAIL();
  } catch (const Error& e) {
    EXPECT_EQ(e.detail().why, "the file is empty");
  }
  write_ldr(folder.path() / "cut.jpg", image);
  const std::string jpeg = read_file(folder.path() / "cut.jpg");
  write_file(folder.path() / "cut.jpg", std::string_view(jpeg).substr(0, jpeg.size() / 2));
  EXPECT_THROW(read_srgb(folder.path() / "cut.jpg"), Error);
}

TEST(Ldr, BytesAsFloatsAreThoseOfTheDecoder) {
  TemporaryFolder dir;
  Image8 image(16, 16, 3);
  for (size_t i = 0; i < image.data().size(); ++i) image.data()[i] = uint8_t(i);
  const ImageF values = floats_of(image);
  write_ldr(dir.path() / "all.png", image);
  const ImageF read = read_srgb(dir.path() / "all.png");
  ASSERT_EQ(values.data().size(), read.data().size());
  for (size_t i = 0; i < 256; ++i) EXPECT_FLOAT_EQ(values.data()[i], read.data()[i]) << i;
  EXPECT_EQ(values.data()[0], 0);
  EXPECT_EQ(values.data()[255], 1);
  EXPECT_EQ(srgb8_from_linear(linear_from_srgb_image(values)).data()[100], 100);
}

TEST(Resize, ShrinkingKeepsTheMeanAndEnlargingKeepsConstants) {
  const ImageF image = noise(64, 48, 3, 5);
  const ImageF small = resized(image, 20, 13);
  double a = 0, b = 0;
  for (float v : image.data()) a += v;
  for (float v : small.data()) b += v;
  EXPECT_NEAR(a / double(image.data().size()), b / double(small.data().size()), 1e-6);
  const ImageF flat = resized(ImageF(5, 4, 1, 0.25f), 33, 21);
  for (float v : flat.data()) EXPECT_FLOAT_EQ(v, 0.25f);
}

TEST(Resample, BicubicReproducesPixelCentresAndLinearRamps) {
  ImageF ramp(16, 16, 1);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 16; ++x) ramp.at(x, y) = float(x) + 2.f * float(y);
  float cubic = 0, linear = 0;
  for (double x = 3.1; x < 12; x += 0.37) {
    sample_bicubic(ramp, x, 7.9, &cubic);
    sample_bilinear(ramp, x, 7.9, &linear);
    EXPECT_NEAR(cubic, (x - 0.5) + 2 * 7.4, 1e-4);
    EXPECT_NEAR(linear, cubic, 1e-4);
  }
}

TEST(Metrics, PsnrIsTheTextbookFormulaAndMasksCount) {
  ImageF a(10, 10, 3, 0.5f), b(10, 10, 3, 0.6f), mask(10, 10, 1, 0.f);
  EXPECT_NEAR(psnr(a, b), 20.0, 1e-5);
  EXPECT_TRUE(std::isnan(psnr(a, b, &mask)));
  mask.at(3, 3) = 1;
  b.at(3, 3, 0) = b.at(3, 3, 1) = b.at(3, 3, 2) = 0.51f;
  EXPECT_NEAR(psnr(a, b, &mask), 40.0, 1e-4);
  EXPECT_EQ(psnr(a, a), 99.0);
}

TEST(Metrics, ErrorsOfSeveralPicturesArePooledByTheirPixels) {
  const ImageF black(4, 4, 1, 0.f), grey(4, 4, 1, 0.1f), wide(4, 12, 1, 0.f);
  SquaredError pooled = squared_error(grey, black);
  EXPECT_NEAR(pooled.psnr(), 20, 1e-5);
  pooled += squared_error(wide, wide);
  EXPECT_NEAR(pooled.psnr(), 20 + 10 * std::log10(4.0), 1e-5);
}

TEST(Metrics, LocalCorrelationTellsTheRightReflectionFromNone) {
  constexpr int kSide = 64;
  ImageF a(kSide, kSide, 3), inverted = a, other = a, brighter = a;
  Rng rng(5, 1);
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide; ++x) {
      const float value = 0.25f + 0.5f * float(rng.uniform_double()), unlike = 0.25f + 0.5f * float(rng.uniform_double());
      for (int c = 0; c < 3; ++c) {
        a.at(x, y, c) = value, inverted.at(x, y, c) = 1 - value, other.at(x, y, c) = unlike;
        brighter.at(x, y, c) = 0.5f * value + 0.01f * float(x);  // of a slow change in brightness windows see little
      }
    }
  EXPECT_NEAR(local_correlation(a, a).value().value(), 1, 1e-6);
  EXPECT_NEAR(local_correlation(inverted, a).value().value(), -1, 1e-6);
  EXPECT_NEAR(local_correlation(other, a).value().value(), 0, 0.05);
  EXPECT_GT(local_correlation(brighter, a).value().value(), 0.9);
  EXPECT_FALSE(local_correlation(ImageF(kSide, kSide, 3, 0.3f), ImageF(kSide, kSide, 3, 0.7f)).value());

  // Of windows in the mask alone: outside, the two have nothing in common.
  ImageF mask(kSide, kSide, 1, 0.f), mixed = other;
  for (int y = 0; y < kSide; ++y)
    for (int x = 0; x < kSide / 2; ++x) {
      mask.at(x, y) = 1;
      for (int c = 0; c < 3; ++c) mixed.at(x, y, c) = a.at(x, y, c);
    }
  EXPECT_NEAR(local_correlation(mixed, a, &mask).value().value(), 1, 1e-6);
  EXPECT_LT(local_correlation(mixed, a).value().value(), 0.7);
  const ImageF nowhere(kSide, kSide, 1, 0.f);
  EXPECT_FALSE(local_correlation(a, a, &nowhere).value());
}

TEST(Metrics, SsimIsOneForEqualImagesAndFallsWithNoise) {
  const ImageF a = noise(40, 30, 3, 6), b = noise(40, 30, 3, 7);
  EXPECT_NEAR(ssim(a, a), 1.0, 1e-12);
  EXPECT_LT(ssim(a, b), 0.2);
}

}  // namespace
}  // namespace vitrine
