// Statistics and relocation of surfels as kernels for a GPU against those of the CPU.
#include "core/learn/optim/blocks/relocate_kernels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/learn/optim/densify.h"
#include "core/learn/optim/rates.h"

namespace vitrine {
namespace {

using blocks::BlockLoops;

constexpr size_t kCount = 700, kCap = 760;

SplatLayer cloud() {
  SplatLayer layer(LayerKind::Diffuse, 1, kCount);
  Rng rng(3);
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = rng.normal();
  for (float& v : layer.values(Attribute::LogScale)) v = 0.4f * v - 3;
  for (size_t i = 0; i < kCount; i += 9) *layer.at(Attribute::Opacity, i) = -6;
  return layer;
}

SurfelStatistics statistics_of(uint64_t picture) {
  SurfelStatistics s;
  s.reset(kCount);
  Rng rng(5, picture);
  for (size_t i = 0; i < kCount; ++i) {
    s.weight[i] = i % 11 == 1 || rng.uniform() < 0.3f ? 0.f : rng.uniform() * 20;
    s.error[i] = s.weight[i] * rng.uniform();
    s.screen_gradient[i] = rng.uniform();
  }
  return s;
}

// State of a training in arrays with room for kCap surfels.
struct Arrays {
  std::array<std::vector<float>, kAttributeCount> x, m, v;
  std::vector<float> weight, error, screen_gradient, share;
  std::vector<uint32_t> seen, steps;
  blocks::AdamColumns columns{};

  explicit Arrays(const SplatLayer& layer) : seen(kCap), steps(kCap, 7) {
    for (auto* values : {&weight, &error, &screen_gradient}) values->resize(kCap);
    share.assign(kCap, 1.f);
    for (const AttributeRow& r : kAttributes) {
      const size_t a = size_t(r.id), width = layer.width(r.id);
      x[a].assign(layer.values(r.id).begin(), layer.values(r.id).end());
      x[a].resize(width * kCap);
      m[a].assign(width * kCap, 1.f);
      v[a].assign(width * kCap, 1.f);
      columns.column[a] = {nullptr, m[a].data(), v[a].data(), x[a].data(), uint32_t(width), 0.f, false, false};
    }
  }
  blocks::AccumulatorArrays sums() { return {weight.data(), error.data(), screen_gradient.data(), share.data(), seen.data()}; }
  bool operator==(const Arrays& o) const {
    return x == o.x && m == o.m && v == o.v && weight == o.weight && share == o.share && seen == o.seen && steps == o.steps;
  }
};

blocks::RelocateBlocks<BlockLoops>::Counts relocate(Arrays& arrays, uint64_t seed) {
  BlockLoops loops(seed);
  for (uint64_t picture = 0; picture < 5; ++picture) {
    const SurfelStatistics s = statistics_of(picture);
    loops.launch(blocks::StatisticsKernel{s.weight.data(), s.error.data(), s.screen_gradient.data(), arrays.sums(), kCount},
                 blocks::blocks_for(kCount, 128));
  }
  blocks::RelocateBlocks<BlockLoops> blocks;
  return blocks.run(loops, {.seed = 4, .step = 50, .idle_weight = 0.02, .growth = 1.2, .cap = kCap}, arrays.columns,
                    arrays.steps.data(), arrays.sums(), kCount);
}

TEST(RelocateBlocks, DivideTheSurfelsThatTheCpuDivides) {
  SplatLayer layer = cloud();
  Arrays arrays(layer), shuffled(layer);
  Adam adam(layer);
  SurfelAccumulator accumulator;
  accumulator.reset(kCount);
  std::fill(accumulator.share.begin(), accumulator.share.end(), 1.f);
  for (uint64_t picture = 0; picture < 5; ++picture) accumulator.add(statistics_of(picture));
  const DensifyConfig config{.growth = 1.2};
  const DensifyCounts cpu = densify(config, {.seed = 4, .step = 50, .cap = kCap}, {layer, adam, accumulator});
  const auto counts = relocate(arrays, 0);
  relocate(shuffled, 5);
  EXPECT_TRUE(arrays == shuffled);
  EXPECT_EQ(counts.relocated, cpu.relocated);
  EXPECT_EQ(counts.added, cpu.added);
  EXPECT_EQ(cpu.added, kCap - kCount);
  EXPECT_GT(cpu.relocated, 100u);
  ASSERT_EQ(layer.size(), kCap);
  for (const AttributeRow& r : kAttributes)
    for (size_t i = 0; i < layer.values(r.id).size(); ++i)
      ASSERT_NEAR(arrays.x[size_t(r.id)][i], layer.values(r.id)[i], 5e-6) << r.name << " " << i;
  size_t forgotten = 0;
  for (size_t i = 0; i < kCap; ++i) {
    ASSERT_NEAR(arrays.share[i], accumulator.share[i], 1e-6);
    forgotten += arrays.steps[i] == 0 && arrays.m[0][3 * i] == 0;
  }
  EXPECT_GT(forgotten, cpu.relocated + cpu.added);
  EXPECT_LT(forgotten, kCap);
}

TEST(StatisticsBlocks, GiveTheStepsOfTheCpu) {
  SplatLayer layer = cloud();
  for (float& v : layer.values(Attribute::Mean)) v *= 4;
  Arrays arrays(layer);
  relocate(arrays, 3);  // leaves other positions, and the statistics of five pictures
  BlockLoops loops;
  blocks::TreeSumMemory<BlockLoops> memory;
  const SurfelStatistics picture = statistics_of(9);
  constexpr uint32_t kTrained = kCount - 10;
  std::vector<uint8_t> active(kCount);
  std::vector<float> all(kCount), place(kCount);
  const float* sum = blocks::tree_sum(loops, memory, arrays.share.data(), kCount);
  loops.launch(blocks::FactorKernel{picture.weight.data(), arrays.share.data(), sum, arrays.x[0].data(), 4.f, active.data(),
                                    all.data(), place.data(), kCount, kTrained},
               blocks::blocks_for(kCount, 128));
  SurfelAccumulator accumulator;
  accumulator.share.assign(arrays.share.begin(), arrays.share.begin() + kCount);
  std::vector<float> rarity;
  accumulator.rarity(4.f, rarity);
  for (size_t i = 0; i < kCount; ++i) {
    ASSERT_EQ(active[i], i < kTrained && picture.weight[i] > 0);
    ASSERT_NEAR(all[i], rarity[i], 1e-6);
    ASSERT_NEAR(place[i], far_factor(arrays.x[0].data() + 3 * i), 1e-6);
  }
  EXPECT_GT(*std::max_element(place.begin(), place.end()), 1.5f);
  EXPECT_GT(*std::max_element(all.begin(), all.end()), 1.01f);
}

TEST(RelocateBlocks, WithoutAnythingToDivideNothingMoves) {
  SplatLayer layer = cloud();
  for (float& v : layer.values(Attribute::Opacity)) v = -9;
  Arrays arrays(layer);
  const auto counts = relocate(arrays, 0);
  EXPECT_EQ(counts.relocated + counts.added, 0u);
  EXPECT_EQ(arrays.x, Arrays(layer).x);
}

}  // namespace
}  // namespace vitrine
