#include "stages/sfm/gains/gains.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.h"
#include "core/base/rng.h"

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
  EXPECT_LT(worst_error(solve_gains(20, capture.points, capture.samples), capture.gains), 1e-5 /* worst seen 3e-7 */);
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

TEST(Gains, OfViewsWithTooFewSamplesAreOneAndReported) {
  Capture capture = synthetic({.views = 10});
  std::erase_if(capture.samples, [](const GainSample& s) { return s.view == 3 && s.point % 100 != 0; });
  for (GainSample& s : capture.samples)
    if (s.view == 5) s.linear_rgb.z = 0.001f;  // blue too dark in every sample
  for (GainSample& s : capture.samples)
    if (s.view == 7) s.linear_rgb = {1, 1, 1};  // clipped throughout
  const GainSolution solution = solve_gains(10, capture.points, capture.samples);
  EXPECT_EQ(solution.undetermined, (std::vector<uint32_t>{3, 5, 7}));
  EXPECT_EQ(solution.gains[3], (Vec3d{1, 1, 1}));
  EXPECT_EQ(solution.gains[7], (Vec3d{1, 1, 1}));
  EXPECT_EQ(solution.gains[5].z, 1);
  EXPECT_NE(solution.gains[5].x, 1);
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

}  // namespace
}  // namespace vitrine
