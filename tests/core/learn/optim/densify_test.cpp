#include "core/learn/optim/densify.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/scene/surfels/activation.h"

namespace vitrine {
namespace {

SplatLayer random_layer(size_t size, float opacity = 0.5f) {
  SplatLayer layer(LayerKind::Diffuse, 1, size);
  Rng rng(1);
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = rng.normal();
  for (float& v : layer.values(Attribute::Opacity)) v = logit(opacity);
  for (float& v : layer.values(Attribute::LogScale)) v = -3;
  return layer;
}

SurfelAccumulator even_statistics(size_t size) {
  SurfelAccumulator a;
  a.reset(size);
  for (size_t i = 0; i < size; ++i) a.weight[i] = 1, a.error[i] = 1, a.seen[i] = 10;
  return a;
}

TEST(Densify, HappensAfterWholePassesThroughThePhotos) {
  DensifyConfig config;
  config.every = 50;
  const auto expect = [&](size_t photos, double window, uint64_t interval, int times, uint64_t pictures) {
    const DensifyRhythm rhythm = densify_rhythm(config, photos, window);
    EXPECT_EQ(rhythm.interval, interval) << photos;
    EXPECT_EQ(rhythm.times, times) << photos;
    EXPECT_EQ(rhythm.pictures, pictures) << photos;
  };
  expect(1, 975, 50, 1, 1);
  expect(31, 975, 62, 1, 31);
  expect(50, 975, 50, 1, 50);
  expect(99, 975, 99, 1, 99);
  expect(300, 975, 300, 6, 300);
  expect(1000, 975, 50, 1, 0);  // no pass fits into the run: as it was asked for
  expect(0, 975, 50, 1, 1);
}

TEST(SurfelAccumulator, CountsPicturesSinceItsReset) {
  SurfelAccumulator sums;
  sums.reset(1);
  const SurfelStatistics away{.screen_gradient = {0.f}, .weight = {0.f}, .error = {}};
  for (int i = 0; i < 3; ++i) sums.add(away);
  EXPECT_EQ(sums.pictures, 3u);
  EXPECT_EQ(sums.seen[0], 0u);
  sums.reset(1);
  EXPECT_EQ(sums.pictures, 0u);
}

// Many photos make densifications rare, but do not keep a layer from its cap.
TEST(Densify, OneThatStandsForSeveralGrowsAsMuch) {
  DensifyConfig config;
  for (const auto& [times, cap, grown] : {std::tuple{1, size_t(1000), size_t(111)},
                                          {5, size_t(1000), size_t(162)},
                                          {5, size_t(130), size_t(130)},
                                          {100000, size_t(400), size_t(400)}}) {
    SplatLayer layer = random_layer(100);
    Adam adam(layer);
    SurfelAccumulator accumulator = even_statistics(layer.size());
    densify(config, {.seed = 1, .step = 50, .cap = cap, .times = times}, {layer, adam, accumulator});
    EXPECT_EQ(layer.size(), grown) << times;
    EXPECT_EQ(accumulator.weight.size(), grown);
  }
}

TEST(SurfelAccumulator, WhatFewPicturesShowIsRareAndSoAreItsCopies) {
  constexpr size_t kSurfels = 40, kRare = 4;
  SurfelAccumulator accumulator;
  accumulator.reset(kSurfels);
  SurfelStatistics statistics;
  statistics.weight.resize(kSurfels);
  statistics.screen_gradient.resize(kSurfels);
  std::vector<float> factor;
  accumulator.rarity(4, factor);
  for (float f : factor) EXPECT_EQ(f, 1) << "nothing is known yet";
  for (int picture = 0; picture < 600; ++picture) {
    std::fill(statistics.weight.begin(), statistics.weight.end(), 1.f);
    for (size_t i = 0; i < kRare; ++i) statistics.weight[i] = picture % 2 == 0 ? 1.f : 0.f;  // every other picture
    statistics.weight[kRare] = picture % 50 == 0 ? 1.f : 0.f;                                // hardly any
    accumulator.add(statistics);
  }
  accumulator.rarity(4, factor);
  for (size_t i = 0; i < kRare; ++i) EXPECT_NEAR(factor[i], 1.86, 0.1);  // mean share (4/2 + 1/50 + 35) / 40 over a half
  EXPECT_EQ(factor[kRare], 4);
  for (size_t i = kRare + 1; i < kSurfels; ++i) EXPECT_EQ(factor[i], 1);

  SplatLayer layer = random_layer(kSurfels);
  Adam adam(layer);
  for (size_t i = 0; i < kSurfels; ++i) accumulator.error[i] = i < kRare ? 1.f : 0.f;
  for (size_t i = kRare; i < kSurfels; ++i) *layer.at(Attribute::Opacity, i) = logit(0.02f);
  densify({.growth = 1.5}, {.cap = 60}, {layer, adam, accumulator});
  ASSERT_EQ(layer.size(), 60u);
  accumulator.rarity(4, factor);
  size_t rare = 0;
  for (size_t i = kSurfels; i < 60; ++i) rare += factor[i] > 1.3f;
  EXPECT_GT(rare, 15u) << "nearly all copies have rare parents";
}

TEST(Divide, MovesTheDeadAndGrowsToTheCapOnly) {
  SplatLayer layer = random_layer(100);
  for (size_t i = 0; i < 10; ++i) *layer.at(Attribute::Opacity, i) = logit(0.004f);
  Adam adam(layer);
  SurfelAccumulator accumulator = even_statistics(100);
  DensifyConfig config;
  config.strategy = DensifyStrategy::Divide;
  config.growth = 1.2;
  DensifyCounts counts = densify(config, {.seed = 1, .step = 50, .cap = 130}, {layer, adam, accumulator});
  EXPECT_EQ(counts.relocated, 10u);
  EXPECT_EQ(counts.added, 20u);
  EXPECT_EQ(layer.size(), 120u);
  EXPECT_EQ(adam.size(), 120u);
  EXPECT_EQ(accumulator.seen.size(), 120u);
  for (size_t i = 0; i < layer.size(); ++i) EXPECT_GT(sigmoid(*layer.at(Attribute::Opacity, i)), 0.01f) << i;
  counts = densify(config, {.seed = 1, .step = 100, .cap = 130}, {layer, adam, accumulator});
  EXPECT_EQ(layer.size(), 130u);
  counts = densify(config, {.seed = 1, .step = 150, .cap = 130}, {layer, adam, accumulator});
  EXPECT_EQ(counts.added, 0u);
}

TEST(Divide, PutsCopiesWhereTheErrorIs) {
  SplatLayer layer = random_layer(1000);
  for (size_t i = 0; i < 1000; ++i) layer.at(Attribute::Mean, i)[0] = i < 100 ? 100.f : 0.f;
  Adam adam(layer);
  SurfelAccumulator accumulator = even_statistics(1000);
  for (size_t i = 0; i < 1000; ++i) accumulator.error[i] = i < 100 ? 5.f : 0.f;
  DensifyConfig config;
  config.strategy = DensifyStrategy::Divide;
  config.growth = 1.5;
  densify(config, {.seed = 1, .step = 1, .cap = 10000}, {layer, adam, accumulator});
  size_t near_error = 0;
  for (size_t i = 1000; i < layer.size(); ++i) near_error += layer.at(Attribute::Mean, i)[0] > 50;
  // Chance of such a surfel: 100 (0.1 + 10) of 100 (0.1 + 10) + 900 * 0.1 = 0.918.
  EXPECT_GT(near_error, 430u);
  EXPECT_LT(near_error, 490u);
}

TEST(Divide, HalvesLieAlongTheLongerAxisAndAddUpToTheParent) {
  SplatLayer layer = random_layer(1, 0.6f);
  layer.at(Attribute::LogScale, 0)[0] = -3;
  layer.at(Attribute::LogScale, 0)[1] = -1;
  const SplatLayer parent = layer;
  Adam adam(layer);
  SurfelAccumulator accumulator = even_statistics(1);
  DensifyConfig config;
  config.strategy = DensifyStrategy::Divide;
  config.growth = 2;
  densify(config, {.seed = 1, .step = 1, .cap = 2}, {layer, adam, accumulator});
  ASSERT_EQ(layer.size(), 2u);
  const float* q = parent.at(Attribute::Rotation, 0);
  const Vec3f axis = rotation_matrix(normalized(Quatf{q[0], q[1], q[2], q[3]})).c1;
  const double sigma = std::exp(-1.0), half = std::exp(double(layer.at(Attribute::LogScale, 0)[1]));
  double at[2];
  for (size_t i = 0; i < 2; ++i) {
    Vec3f offset{};
    for (size_t c = 0; c < 3; ++c) offset[c] = layer.at(Attribute::Mean, i)[c] - parent.at(Attribute::Mean, 0)[c];
    at[i] = dot(offset, axis);
    EXPECT_NEAR(length(offset), std::abs(at[i]), 1e-5) << "moved along the axis alone";
    EXPECT_FLOAT_EQ(*layer.at(Attribute::Opacity, i), *parent.at(Attribute::Opacity, 0));
    EXPECT_LT(layer.at(Attribute::LogScale, i)[0], -3);
  }
  EXPECT_NEAR(at[0] + at[1], 0, 1e-5);
  for (double x = -1.5 * sigma; x <= 1.5 * sigma; x += 0.1 * sigma) {
    const auto profile = [&](double centre, double s) { return std::exp(-0.5 * (x - centre) * (x - centre) / (s * s)); };
    EXPECT_NEAR(profile(at[0], half) + profile(at[1], half), profile(0, sigma), 0.25) << x / sigma;  // worst seen 0.21
  }
}

TEST(Divide, MovesWhatHardlyAnyPixelSees) {
  SplatLayer layer = random_layer(100);
  Adam adam(layer);
  SurfelAccumulator accumulator = even_statistics(100);
  for (size_t i = 0; i < 7; ++i) accumulator.weight[i] = 1e-3f;
  DensifyConfig config;
  config.strategy = DensifyStrategy::Divide;
  config.idle_weight = 0.05;
  const DensifyCounts counts = densify(config, {.seed = 1, .step = 1, .cap = 100}, {layer, adam, accumulator});
  EXPECT_EQ(counts.relocated, 7u);
  EXPECT_EQ(layer.size(), 100u);
}

TEST(Divide, SurvivesALayerWithoutLivingSurfels) {
  SplatLayer layer = random_layer(5, 0.001f);
  Adam adam(layer);
  SurfelAccumulator accumulator = even_statistics(5);
  const DensifyCounts counts = densify({}, {.seed = 1, .step = 50, .cap = 50}, {layer, adam, accumulator});
  EXPECT_EQ(counts.relocated + counts.added, 0u);
}

TEST(Classic, ClonesSmallSplitsLargeDropsFaint) {
  SplatLayer layer = random_layer(4);
  const float large = std::log(0.5f), small = std::log(0.001f);
  for (size_t i = 0; i < 4; ++i)
    for (size_t c = 0; c < 2; ++c) layer.at(Attribute::LogScale, i)[c] = i == 0 ? large : small;
  *layer.at(Attribute::Opacity, 3) = logit(0.01f);
  const SplatLayer before = layer;
  Adam adam(layer);
  SurfelAccumulator accumulator = even_statistics(4);
  accumulator.screen_gradient = {1, 1, 0, 0};
  DensifyConfig config;
  config.strategy = DensifyStrategy::Classic;
  const DensifyCounts counts = densify(config, {.seed = 1, .step = 50, .cap = 100}, {layer, adam, accumulator});
  EXPECT_EQ(counts.added, 2u);
  EXPECT_EQ(counts.removed, 1u);
  ASSERT_EQ(layer.size(), 5u);  // 0' 1 2 | split of 0, clone of 1
  EXPECT_FLOAT_EQ(layer.at(Attribute::LogScale, 0)[0], large - std::log(1.6f));
  EXPECT_FLOAT_EQ(layer.at(Attribute::LogScale, 3)[0], large - std::log(1.6f));
  EXPECT_NE(layer.at(Attribute::Mean, 3)[0], layer.at(Attribute::Mean, 0)[0]);
  EXPECT_EQ(layer.at(Attribute::Mean, 4)[0], before.at(Attribute::Mean, 1)[0]);
  EXPECT_EQ(layer.at(Attribute::LogScale, 4)[0], small);
}

TEST(Classic, KeepsTheCapAndPrefersHighGradients) {
  SplatLayer layer = random_layer(10);
  Adam adam(layer);
  SurfelAccumulator accumulator = even_statistics(10);
  for (size_t i = 0; i < 10; ++i) accumulator.screen_gradient[i] = float(i + 1);
  DensifyConfig config;
  config.strategy = DensifyStrategy::Classic;
  config.split_size_rel = 1;
  const SplatLayer before = layer;
  densify(config, {.seed = 1, .step = 50, .cap = 12}, {layer, adam, accumulator});
  ASSERT_EQ(layer.size(), 12u);
  EXPECT_EQ(layer.at(Attribute::Mean, 10)[0], before.at(Attribute::Mean, 9)[0]);
  EXPECT_EQ(layer.at(Attribute::Mean, 11)[0], before.at(Attribute::Mean, 8)[0]);
}

TEST(Noise, MovesOnlyNearlyTransparentSurfelsAndOnlyInTheirPlane) {
  SplatLayer layer = random_layer(2);
  *layer.at(Attribute::Opacity, 1) = logit(0.002f);
  for (size_t i = 0; i < 2; ++i) {
    float* q = layer.at(Attribute::Rotation, i);
    q[0] = 1, q[1] = q[2] = q[3] = 0;  // the plane is z = constant
  }
  const SplatLayer before = layer;
  add_position_noise(layer, 1.f, 1, 1);
  EXPECT_EQ(layer.at(Attribute::Mean, 0)[0], before.at(Attribute::Mean, 0)[0]);
  EXPECT_NE(layer.at(Attribute::Mean, 1)[0], before.at(Attribute::Mean, 1)[0]);
  EXPECT_EQ(layer.at(Attribute::Mean, 1)[2], before.at(Attribute::Mean, 1)[2]);
}

// The noise of a surfel grows with the square of its size; what is far is large, and would be gone after one step.
TEST(Densification, WhatIsFarWalksAboutTheSameAngle) {
  constexpr float kNear = 1, kFar = 100, kAngle = 0.02f;  // distances, and how large both look
  SplatLayer layer = random_layer(2, 0.001f);
  for (size_t i : {0, 1}) {
    float* mean = layer.at(Attribute::Mean, i);
    mean[0] = mean[1] = 0, mean[2] = i == 0 ? kNear : kFar;
    std::fill_n(layer.at(Attribute::LogScale, i), 2, std::log(kAngle * mean[2]));
    float* q = layer.at(Attribute::Rotation, i);
    q[0] = 1, q[1] = q[2] = q[3] = 0;
  }
  double angle[2] = {0, 0};
  for (uint64_t step = 0; step < 200; ++step) {
    SplatLayer moved = layer;
    add_position_noise(moved, 10.f, 1, step);
    for (size_t i : {0, 1}) {
      const float* mean = moved.at(Attribute::Mean, i);
      angle[i] += std::hypot(double(mean[0]), double(mean[1])) / double(mean[2]) / 200;
    }
  }
  EXPECT_GT(angle[0], 1e-4);
  EXPECT_GT(angle[1], angle[0]);
  EXPECT_LT(angle[1], 10 * angle[0]);
}

TEST(Densification, SameBitsForAnyNumberOfThreads) {
  const auto run = [](int threads) {
    set_thread_limit(threads);
    SplatLayer layer = random_layer(3000, 0.02f);
    Adam adam(layer);
    SurfelAccumulator accumulator = even_statistics(3000);
    densify({}, {.seed = 3, .step = 50, .cap = 5000}, {layer, adam, accumulator});
    add_position_noise(layer, 1.f, 3, 50);
    set_thread_limit(0);
    return layer;
  };
  EXPECT_EQ(run(1), run(2));
}

}  // namespace
}  // namespace vitrine
