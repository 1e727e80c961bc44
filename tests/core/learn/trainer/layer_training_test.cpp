#include "core/learn/trainer/layer_training.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/foundation/math/spherical_harmonics.h"

namespace vitrine {
namespace {

// Black for long, because one photo wants it darker than black (it looks at the wall through a bright reflection), then bright.
TEST(LayerTraining, WhatWasDrivenToBlackComesBack) {
  constexpr size_t kSurfels = 3, kUntouched = 2;
  SplatLayer layer(LayerKind::Diffuse, 1, kSurfels);
  SplatLayer grad = layer;
  LayerTraining training(layer);
  SurfelStatistics statistics;
  statistics.weight = {1, 1, 0};
  statistics.screen_gradient.resize(kSurfels);
  AttributeRates rates{};
  rates[static_cast<size_t>(Attribute::ShDc)] = 0.01f;
  const auto radiance = [&](size_t i, size_t c) { return 0.5f + kShDc * layer.at(Attribute::ShDc, i)[c]; };
  *layer.at(Attribute::ShDc, kUntouched) = -100;

  const auto steps = [&](int count, float towards) {
    for (float& g : grad.values(Attribute::ShDc)) g = towards;
    for (int i = 0; i < count; ++i) training.descend(grad, statistics, {.rates = rates}, layer);
  };
  steps(1000, 1.f);
  for (size_t i = 0; i < kUntouched; ++i)
    for (size_t c = 0; c < 3; ++c) {
      EXPECT_GT(radiance(i, c), 0) << "the clamp of the colour would take its gradient away";
      EXPECT_LT(radiance(i, c), 0.01);
    }
  EXPECT_EQ(*layer.at(Attribute::ShDc, kUntouched), -100) << "did not take part";
  steps(1000, -1.f);
  for (size_t i = 0; i < kUntouched; ++i) EXPECT_GT(radiance(i, 0), 0.5);
}

// Photos see angles: at 100 radii of the cameras a step is twenty times as long as at 5, from where on it grows.
TEST(LayerTraining, WhatIsFarTakesLongerSteps) {
  constexpr float kNear[3] = {1, 4, 0}, kFar[3] = {60, 0, 80}, kRate = 0.01f;
  SplatLayer layer(LayerKind::Diffuse, 0, 2);
  std::copy_n(kNear, 3, layer.at(Attribute::Mean, 0));
  std::copy_n(kFar, 3, layer.at(Attribute::Mean, 1));
  SplatLayer grad = layer;
  for (const AttributeRow& r : kAttributes) std::ranges::fill(grad.values(r.id), 1.f);
  LayerTraining training(layer);
  SurfelStatistics statistics;
  statistics.weight = {1, 1};
  statistics.screen_gradient.resize(2);
  AttributeRates rates{};
  rates.fill(kRate);
  SplatLayer moved = layer;
  training.descend(grad, statistics, {.rates = rates}, moved);
  for (size_t c = 0; c < 3; ++c) {
    EXPECT_NEAR(moved.at(Attribute::Mean, 0)[c], kNear[c] - kRate, 1e-6);
    EXPECT_NEAR(moved.at(Attribute::Mean, 1)[c], kFar[c] - 20 * kRate, 1e-4);
  }
  for (size_t i : {0, 1}) EXPECT_NEAR(*moved.at(Attribute::LogScale, i), *layer.at(Attribute::LogScale, i) - kRate, 1e-6);
}

}  // namespace
}  // namespace vitrine
