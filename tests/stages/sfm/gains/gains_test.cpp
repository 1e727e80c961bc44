#include "stages/sfm/gains/gains.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"

namespace vitrine {
namespace {

struct Capture {
  std::vector<Vec3d> gains;  // truth, geometric mean 1 per channel
  std::vector<GainSample> samples;
  size_t points = 0;
};

struct CaptureDesc {
  size_t views = 20, points = 1500;
  double stops = 1.5;   // half range of the exposures, 0 = fixed exposure
  double noise = 0.05;  // of log(observed)
  double outliers = 0;  // share of samples that show something else
  uint64_t seed = 1;
};

// A ring of views; each point is seen by a run of neighbouring ones, as in a real orbit.
Capture synthetic(const CaptureDesc& desc) {
  Rng rng(desc.seed);
  Capture capture;
  capture.points = desc.points;
  Vec3d mean;
  for (size_t v = 0; v < desc.views; ++v) {
    const double exposure = desc.stops * std::log(2.0) * (2 * rng.uniform_double() - 1);
    Vec3d g;
    for (size_t c = 0; c < 3; ++c) g[c] = exposure + (desc.stops > 0 ? 0.1 * rng.normal() : 0.0);
    capture.gains.push_back(g);
    mean += g / double(desc.views);
  }
  for (Vec3d& g : capture.gains)
    for (size_t c = 0; c < 3; ++c) g[c] = std::exp(g[c] - mean[c]);
  for (size_t k = 0; k < desc.points; ++k) {
    const Vec3d colour{std::exp(-3 + 2 * rng.uniform_double()), std::exp(-3 + 2 * rng.uniform_double()),
                       std::exp(-3 + 2 * rng.uniform_double())};
    const size_t first = rng.below(static_cast<uint32_t>(desc.views)), length = 2 + rng.below(6);
    for (size_t i = 0; i < length; ++i) {
      const size_t v = (first + i) % desc.views;
      GainSample s{static_cast<uint32_t>(v), static_cast<uint32_t>(k), {}};
      const bool outlier = rng.uniform_double() < desc.outliers;
      // An outlier is a highlight more often than not: the disturbance has a bias.
      const double wrong = outlier ? 0.5 + 1.0 * rng.normal() : 0.0;
      for (size_t c = 0; c < 3; ++c) {
        const double value = capture.gains[v][c] * colour[c] * std::exp(desc.noise * rng.normal() + wrong);
        s.linear_rgb[c] = static_cast<float>(std::min(value, 1.0));  // the sensor clips
      }
      capture.samples.push_back(s);
    }
  }
  return capture;
}

double worst_error(const GainSolution& solution, const std::vector<Vec3d>& truth) {
  double worst = 0;
  for (size_t v = 0; v < truth.size(); ++v)
    for (size_t c = 0; c < 3; ++c) worst = std::max(worst, std::abs(solution.gains[v][c] / truth[v][c] - 1));
  return worst;
}

TEST(Gains, AreExactWithoutNoise) {
  const Capture capture = synthetic({.noise = 0});
  EXPECT_LT(worst_error(solve_gains(20, capture.points, capture.samples), capture.gains),
            1e-3 /* worst seen 3e-4: the pull of the prior */);
}

TEST(Gains, AreRecoveredWithinOnePercentUnderNoiseAndOutliers) {
  for (uint64_t seed = 1; seed <= 2; ++seed) {
    const Capture capture = synthetic({.points = 6000, .noise = 0.03, .outliers = 0.15, .seed = seed});
    const GainSolution solution = solve_gains(20, capture.points, capture.samples);
    EXPECT_LT(worst_error(solution, capture.gains), 0.01 /* worst seen 0.004 */) << "seed " << seed;
    EXPECT_TRUE(solution.undetermined.empty());
    EXPECT_NEAR(solution.spread, 0.03, 0.01);
  }
}

TEST(Gains, OfAFixedExposureAreMeasuredWithinOnePercentAndThenSetToOne) {
  const Capture capture = synthetic({.points = 6000, .stops = 0, .noise = 0.03, .outliers = 0.15});
  const std::vector<Vec3d> ones(20, Vec3d{1, 1, 1});
  const GainSolution measured = solve_gains(20, capture.points, capture.samples, {.fixed_deviation = 0});
  EXPECT_FALSE(measured.fixed_exposure);
  EXPECT_LT(worst_error(measured, ones), 0.01 /* worst seen 0.004 */);
  const GainSolution judged = solve_gains(20, capture.points, capture.samples);
  EXPECT_TRUE(judged.fixed_exposure);
  EXPECT_EQ(judged.gains, ones);
}

TEST(Gains, OneBrighterPhotoIsNoFixedExposure) {
  Capture capture = synthetic({.points = 6000, .stops = 0, .noise = 0.03});
  for (GainSample& s : capture.samples)
    if (s.view == 4) s.linear_rgb = 1.08f * s.linear_rgb;
  const GainSolution solution = solve_gains(20, capture.points, capture.samples);
  EXPECT_FALSE(solution.fixed_exposure);
  EXPECT_NEAR(solution.gains[4].y / solution.gains[14].y, 1.08, 0.01);
}

TEST(Gains, HaveGeometricMeanOne) {
  const Capture capture = synthetic({.outliers = 0.1});
  const GainSolution solution = solve_gains(20, capture.points, capture.samples);
  for (size_t c = 0; c < 3; ++c) {
    double sum = 0;
    for (const Vec3d& g : solution.gains) sum += std::log(g[c]);
    EXPECT_NEAR(sum, 0, 1e-9);
  }
}

TEST(Gains, OfViewsWithTooFewSamplesAreThoseOfThePriorAndReported) {
  Capture capture = synthetic({.views = 10});
  std::erase_if(capture.samples, [](const GainSample& s) { return s.view == 3 && s.point % 100 != 0; });
  for (GainSample& s : capture.samples)
    if (s.view == 5) s.linear_rgb.z = 0.001f;  // blue too dark in every sample
  for (GainSample& s : capture.samples)
    if (s.view == 7) s.linear_rgb = {1, 1, 1};  // clipped throughout
  const GainSolution solution = solve_gains(10, capture.points, capture.samples);
  EXPECT_EQ(solution.undetermined, (std::vector<uint32_t>{3, 5, 7}));
  // The prior: an average photo; in a channel alone, the exposure of the other two.
  EXPECT_EQ(solution.gains[3], solution.gains[7]);
  const double average = std::log(solution.gains[3].y), blue = solution.gains[5].z / solution.gains[3].z,
               others = std::sqrt(solution.gains[5].x * solution.gains[5].y) / solution.gains[3].y;
  EXPECT_NEAR(average, 0, 0.5);
  EXPECT_GT(std::abs(std::log(others)), 0.2);
  EXPECT_NEAR(blue / others, 1, 0.05);
}

// Ratio of the largest to the smallest gain of a channel, and of two channels of one photo.
struct Ratios {
  double exposure = 1, balance = 1;
};
Ratios ratios(const GainSolution& solution) {
  Ratios r;
  for (const Vec3d& g : solution.gains) {
    r.balance = std::max(r.balance, std::max({g.x, g.y, g.z}) / std::min({g.x, g.y, g.z}));
    for (const Vec3d& h : solution.gains)
      for (size_t c = 0; c < 3; ++c) r.exposure = std::max(r.exposure, g[c] / h[c]);
  }
  return r;
}

// The white balance really changes, in every other photo and then from one photo on: the prior lets go of it.
TEST(Gains, OfAnotherWhiteBalanceAreFoundWithinAFewPercent) {
  for (const bool alternating : {true, false}) {
    Capture capture = synthetic({.points = 6000, .stops = 0, .noise = 0.03, .outliers = 0.1});
    const auto blue = [&](uint32_t v) { return (alternating ? v % 2 == 0 : v < 10) ? 0.6 : 1.0; };
    for (GainSample& s : capture.samples) s.linear_rgb.z *= float(blue(s.view));
    for (uint32_t v = 0; v < 20; ++v) capture.gains[v].z = blue(v) / std::sqrt(0.6);
    EXPECT_LT(worst_error(solve_gains(20, capture.points, capture.samples), capture.gains), 0.05 /* worst seen 0.027 */);
  }
}

// What a photo of a dark object shows is partly light that never met its colour, and every photo has another share of it.
TEST(Gains, OfFewDarkBlueSamplesUnderAVeilStayNearNeutral) {
  Rng rng(5);
  std::vector<double> veil;
  for (size_t v = 0; v < 12; ++v) veil.push_back(0.01 * rng.uniform_double());
  std::vector<GainSample> samples;
  for (uint32_t k = 0; k < 150; ++k) {
    const double grey = 0.5 + rng.uniform_double();
    const uint32_t first = rng.below(12);
    for (uint32_t i = 0; i < 4; ++i) {
      const uint32_t v = (first + i) % 12;
      GainSample s{v, k, {}};
      const Vec3d bronze{0.3, 0.18, 0.04};
      for (size_t c = 0; c < 3; ++c)
        s.linear_rgb[c] = static_cast<float>(grey * bronze[c] * std::exp(0.05 * rng.normal()) + veil[v]);
      samples.push_back(s);
    }
  }
  const Ratios r = ratios(solve_gains(12, 150, samples));
  EXPECT_LT(r.balance, 1.1 /* worst seen 1.035 */);
  EXPECT_LT(r.exposure, 1.2 /* worst seen 1.10 */);
}

// An object turns under lamps that stand still: its dark paint brightens from photo to photo as it turns towards them, the less
// the more colour it has, and no track is long. Half of the tracks show something that does not change.
TEST(Gains, DoNotFollowTheShadingOfAnObjectThatTurns) {
  Rng rng(7);
  constexpr uint32_t kViews = 24;
  std::vector<GainSample> samples;
  for (uint32_t k = 0; k < 3000; ++k) {
    const bool steady = k % 2 == 0;
    const uint32_t first = rng.below(kViews), length = 3 + rng.below(3);
    const double grey = 0.6 + 0.8 * rng.uniform_double();
    for (uint32_t i = 0; i < length && first + i < kViews; ++i) {
      GainSample s{first + i, k, {}};
      const Vec3d paint = steady ? Vec3d{0.6, 0.6, 0.6} : Vec3d{0.25, 0.15, 0.06}, turn{0.03, 0.05, 0.1};
      for (size_t c = 0; c < 3; ++c)
        s.linear_rgb[c] =
            static_cast<float>(grey * paint[c] * std::exp((steady ? 0 : turn[c] * double(i)) + 0.03 * rng.normal()));
      samples.push_back(s);
    }
  }
  const Ratios r = ratios(solve_gains(kViews, 3000, samples));
  EXPECT_LT(r.balance, 1.1 /* worst seen 1.02 */);
  EXPECT_LT(r.exposure, 1.2 /* worst seen 1.12 */);
}

// Exposures of whole stops and hardly a track: EXIF knows better. With many tracks that disagree, EXIF does not decide.
TEST(Gains, OfFewTracksFollowExif) {
  Capture few = synthetic({.points = 60, .noise = 0.3});
  std::vector<std::optional<double>> exif;
  for (const Vec3d& g : few.gains) exif.push_back(7 + std::log(g.x * g.y * g.z) / 3);
  const auto error = [&](const GainSolution& solution, std::span<const std::optional<double>> log_exposures) {
    double worst = 0;
    for (size_t v = 0; v < 20; ++v)
      for (size_t u = 0; u < 20; ++u)
        worst = std::max(worst,
                         std::abs(std::log(solution.gains[v].y / solution.gains[u].y) - *log_exposures[v] + *log_exposures[u]));
    return worst;
  };
  EXPECT_LT(error(solve_gains(20, few.points, few.samples, {}, exif), exif), 0.1);
  EXPECT_GT(error(solve_gains(20, few.points, few.samples), exif), 1);
  const Capture plenty = synthetic({.points = 6000, .noise = 0.03, .outliers = 0.1});
  std::vector<std::optional<double>> wrong(20, 0.0);
  wrong[3] = 1;
  wrong[4] = std::nullopt;
  EXPECT_LT(worst_error(solve_gains(20, plenty.points, plenty.samples, {}, wrong), plenty.gains), 0.02);
}

TEST(Gains, NothingToGoByGivesOnes) {
  const GainSolution solution = solve_gains(3, 0, {});
  EXPECT_EQ(solution.gains, std::vector<Vec3d>(3, Vec3d{1, 1, 1}));
  EXPECT_EQ(solution.undetermined.size(), 3u);
}

TEST(Gains, UseTheLongestTracksWhenThereAreTooMany) {
  const Capture capture = synthetic({.points = 4000});
  const GainSolution all = solve_gains(20, capture.points, capture.samples);
  const GainSolution few = solve_gains(20, capture.points, capture.samples, {.max_points = 1000});
  EXPECT_LT(few.samples, all.samples / 2);
  EXPECT_LT(worst_error(few, capture.gains), 0.05);
}

TEST(Gains, AreTheSameForAnyNumberOfThreads) {
  const Capture capture = synthetic({.outliers = 0.1});
  std::vector<std::vector<Vec3d>> results;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    results.push_back(solve_gains(20, capture.points, capture.samples).gains);
  }
  set_thread_limit(0);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(TrackSamples, ReadTheColourAroundEachObservation) {
  ColmapModel model;
  model.cameras = {colmap_pinhole(1, {20, 10, 10, 10, 10, 5})};
  model.images = {{1, {}, {}, 1, "a", {{5.5, 4.5, 9}, {5.5, 4.5, kNoPoint3D}, {0.5, 4.5, 9}, {19.9, 4.5, 9}, {5.5, 4.5, 77}}},
                  {2, {}, {}, 1, "b", {{10.5, 5.5, 9}}}};
  model.points = {{9, {}, {}, 0, {{1, 0}, {2, 0}}}};
  const std::vector<GainSample> samples = track_samples(model, [](const ColmapImage& image) {
    ImageF photo(20, 10, 3);
    for (int y = 0; y < 10; ++y)
      for (int x = 0; x < 20; ++x)
        for (int c = 0; c < 3; ++c) photo.at(x, y, c) = float(image.id) * (0.01f * float(x) + 0.1f * float(c));
    return photo;
  });
  // Observations without a point, of an unknown point, or at the border of the photo say nothing.
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_NEAR(samples[0].linear_rgb.y, 0.05f + 0.1f, 1e-6f);
  EXPECT_EQ(samples[1].view, 1u);
  EXPECT_EQ(samples[1].point, 0u);
  EXPECT_NEAR(samples[1].linear_rgb.x, 0.2f, 1e-6f);
}

// Clipping takes a channel out of proportion: one pixel of it is enough.
TEST(TrackSamples, OfPatchesWithAClippedPixelTakeNoPart) {
  ImageF photo(20, 10, 3, 0.4f);
  Vec3f colour;
  EXPECT_TRUE(sample_colour(photo, 10.5, 5.5, 2, colour));
  photo.at(12, 7, 2) = 1;
  EXPECT_FALSE(sample_colour(photo, 10.5, 5.5, 2, colour));
  EXPECT_TRUE(sample_colour(photo, 9.5, 5.5, 2, colour));
}

}  // namespace
}  // namespace vitrine
