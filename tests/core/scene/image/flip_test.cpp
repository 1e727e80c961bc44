// FLIP: closed forms for plain pictures, the properties of the measure, and whole pictures against numbers of a separate program
// that follows the paper's equations with two-dimensional kernels.
#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/image/metrics.h"

namespace vitrine {
namespace {

ImageF plain(float r, float g, float b) {
  ImageF image(24, 16, 3);
  for (size_t i = 0; i < image.pixel_count(); ++i)
    image.data()[3 * i] = r, image.data()[3 * i + 1] = g, image.data()[3 * i + 2] = b;
  return image;
}

// Ramps of red and green, and a blue pattern of multipliers p and q.
ImageF pattern(float red, int p, int q, int modulus) {
  ImageF image(24, 16, 3);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 24; ++x) {
      image.at(x, y, 0) = red * float(x) / 23;
      image.at(x, y, 1) = float(y) / 15;
      image.at(x, y, 2) = float((x * p + y * q) % modulus) / float(modulus - 1);
    }
  return image;
}

TEST(Flip, PlainColoursHaveTheClosedForm) {
  // Green and blue are the two ends of the range. Black and white: 100^0.7 = 25.119 of the largest distance, 41.276, is 0.60855:
  // 0.95 + (0.60855 - 0.4) / 0.6 * 0.05.
  EXPECT_NEAR(flip(plain(0, 1, 0), plain(0, 0, 1)), 1, 1e-6);
  EXPECT_NEAR(flip(plain(0, 0, 0), plain(1, 1, 1)), 0.967380, 2e-6);
  EXPECT_NEAR(flip(plain(1, 0, 0), plain(0, 0, 1)), 0.965079, 2e-6);
  // sRGB 0.5 and 0.6 have L* 53.389 and 63.223.
  EXPECT_NEAR(flip(plain(0.5f, 0.5f, 0.5f), plain(0.6f, 0.6f, 0.6f)), 0.285013, 2e-6);
  EXPECT_NEAR(flip(plain(0.2f, 0.4f, 0.6f), plain(0.25f, 0.4f, 0.5f)), 0.229612, 2e-6);
}

TEST(Flip, PicturesAgreeWithTwoDimensionalKernels) {
  const ImageF a = pattern(1, 7, 5, 11), b = pattern(0.9f, 5, 7, 13);
  EXPECT_NEAR(flip(a, b), 0.203536, 5e-6);
  const ImageF fine = flip_map(a, b);
  EXPECT_NEAR(fine.at(0, 0), 0.224458, 1e-5);
  EXPECT_NEAR(fine.at(7, 5), 0.023144, 1e-5);
  EXPECT_NEAR(*std::max_element(fine.data().begin(), fine.data().end()), 0.572602, 1e-5);
  EXPECT_NEAR(flip(a, b, nullptr, 20), 0.392490, 5e-6);

  // An edge of one picture alone raises the difference next to it above that of the plain side.
  ImageF step = plain(0.2f, 0.2f, 0.2f);
  for (int y = 0; y < 16; ++y)
    for (int x = 12; x < 24; ++x)
      for (int c = 0; c < 3; ++c) step.at(x, y, c) = 0.8f;
  const ImageF edge = flip_map(step, plain(0.2f, 0.2f, 0.2f));
  EXPECT_NEAR(edge.at(9, 8), 0.272131, 1e-5);
  EXPECT_NEAR(edge.at(13, 8), 0.980064, 1e-5);
  EXPECT_NEAR(edge.at(23, 8), 0.952464, 1e-5);
}

TEST(Flip, IsZeroForEqualPicturesSymmetricAndRisesWithNoise) {
  const ImageF a = pattern(1, 7, 5, 11), b = pattern(0.9f, 5, 7, 13);
  EXPECT_EQ(flip(a, a), 0);
  EXPECT_EQ(flip(a, b), flip(b, a));
  double previous = 0;
  for (const float strength : {0.02f, 0.05f, 0.1f, 0.2f, 0.4f}) {
    ImageF noisy = plain(0.5f, 0.5f, 0.5f);
    Rng rng(3, 1);
    for (float& v : noisy.data()) v += strength * (float(rng.uniform_double()) - 0.5f);
    const double error = flip(noisy, plain(0.5f, 0.5f, 0.5f));
    EXPECT_GT(error, 1.2 * previous) << strength;
    previous = error;
  }
  // From further away, with more pixels in a degree, noise is averaged by the eye.
  ImageF noisy = plain(0.5f, 0.5f, 0.5f);
  Rng rng(3, 1);
  for (float& v : noisy.data()) v += 0.2f * (float(rng.uniform_double()) - 0.5f);
  EXPECT_LT(flip(noisy, plain(0.5f, 0.5f, 0.5f), nullptr, 134), flip(noisy, plain(0.5f, 0.5f, 0.5f), nullptr, 34));
}

TEST(Flip, CountsPixelsOfTheMask) {
  ImageF left(24, 16, 1, 0.f);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 4; ++x) left.at(x, y) = 1;
  const ImageF a = pattern(1, 7, 5, 11), b = pattern(0.9f, 5, 7, 13), map = flip_map(a, b);
  double sum = 0;
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 4; ++x) sum += map.at(x, y);
  EXPECT_NEAR(flip(a, b, &left), sum / 64, 1e-9);
  const ImageF nowhere(24, 16, 1, 0.f);
  EXPECT_TRUE(std::isnan(flip(a, b, &nowhere)));
}

TEST(Flip, IsTheSameForAnyNumberOfThreads) {
  const ImageF a = pattern(1, 7, 5, 11), b = pattern(0.9f, 5, 7, 13);
  set_thread_limit(1);
  const ImageF one = flip_map(a, b);
  set_thread_limit(0);
  const ImageF all = flip_map(a, b);
  EXPECT_TRUE(std::ranges::equal(one.data(), all.data()));
}

}  // namespace
}  // namespace vitrine
