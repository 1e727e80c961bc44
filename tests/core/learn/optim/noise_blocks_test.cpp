// The random walk of surfels as a kernel for a GPU against that of the CPU.
#include "core/learn/optim/blocks/noise_kernel.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/learn/optim/densify.h"

namespace vitrine {
namespace {

TEST(NoiseBlocks, NormalDeviatesAreThoseOfTheCpu) {
  double worst = 0, square = 0;
  constexpr int kDraws = 100000;
  for (uint64_t i = 0; i < kDraws; ++i) {
    Rng rng(6, i), raw(6, i);
    const uint64_t first = raw.next_u64(), second = raw.next_u64();
    const double here = rng.normal(), there = double(blocks::normal_deviate(first, second).v);
    worst = std::max(worst, std::abs(here - there));
    square += there * there;
  }
  EXPECT_LT(worst, 2e-6);
  EXPECT_NEAR(square / kDraws, 1, 0.02);
}

TEST(NoiseBlocks, NormalDeviatesAtTheEndsAreNumbers) {
  for (const uint64_t turn : {uint64_t{0}, ~uint64_t{0}, uint64_t{1} << 63, (uint64_t{1} << 61) - 1, uint64_t{7} << 61}) {
    EXPECT_EQ(blocks::normal_deviate(0, turn).v, 0.f);
    EXPECT_LE(std::abs(blocks::normal_deviate(~uint64_t{0}, turn).v), 8.6f);  // the largest of Rng: sqrt(106 ln 2)
  }
  EXPECT_NEAR(blocks::normal_deviate(~uint64_t{0}, 0).v, std::sqrt(106 * std::log(2.0)), 1e-5);
}

// `count` surfels, most of them nearly transparent, some far away.
SplatLayer faint_cloud(size_t count) {
  SplatLayer layer(LayerKind::Diffuse, 1, count);
  Rng rng(2);
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = rng.normal();
  for (float& v : layer.values(Attribute::Opacity)) v = 1.5f * v - 5;
  for (float& v : layer.values(Attribute::LogScale)) v = 0.5f * v - 1;
  for (float& v : layer.values(Attribute::Mean)) v *= 4;
  return layer;
}

std::vector<float> walked(const SplatLayer& layer, float strength, uint64_t shuffle) {
  blocks::BlockLoops loops(shuffle);
  std::vector<float> mean(layer.values(Attribute::Mean).begin(), layer.values(Attribute::Mean).end());
  blocks::SurfelArrays surfels{};
  surfels.mean = mean.data();
  surfels.rotation = layer.values(Attribute::Rotation).data();
  surfels.log_scale = layer.values(Attribute::LogScale).data();
  surfels.opacity = layer.values(Attribute::Opacity).data();
  surfels.count = uint32_t(layer.size());
  blocks::add_position_noise(loops, surfels, mean.data(), strength, 9, 1234567);
  return mean;
}

TEST(NoiseBlocks, SurfelsWalkAsOnTheCpu) {
  SplatLayer layer = faint_cloud(777);
  const std::vector<float> there = walked(layer, 0.8f, 0);
  EXPECT_EQ(walked(layer, 0.8f, 4), there);
  const std::vector<float> before(layer.values(Attribute::Mean).begin(), layer.values(Attribute::Mean).end());
  add_position_noise(layer, 0.8f, 9, 1234567);
  size_t moved = 0;
  for (size_t i = 0; i < before.size(); ++i) {
    const double step = std::abs(double(layer.values(Attribute::Mean)[i]) - before[i]);
    moved += step > 1e-3;
    ASSERT_NEAR(there[i], layer.values(Attribute::Mean)[i], 2e-6 * std::abs(before[i]) + 2e-5 * step + 1e-6) << i;
  }
  EXPECT_GT(moved, 600u);
  EXPECT_LT(moved, 2000u);
  EXPECT_EQ(walked(layer, 0.f, 0),
            std::vector<float>(layer.values(Attribute::Mean).begin(), layer.values(Attribute::Mean).end()));
}

}  // namespace
}  // namespace vitrine
