// Adam as kernels for a GPU against Adam of the CPU.
#include "core/learn/optim/blocks/adam_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/foundation/base/rng.h"
#include "core/learn/optim/adam.h"

namespace vitrine {
namespace {

using blocks::BlockLoops;

SplatLayer noise(size_t size, uint64_t seed) {
  SplatLayer layer(LayerKind::Diffuse, 1, size);
  Rng rng(seed);
  for (const AttributeRow& r : kAttributes)
    for (float& v : layer.values(r.id)) v = rng.normal();
  return layer;
}

// A layer with its moments, whose columns are stepped by kernels.
struct BlockLayer {
  SplatLayer x, m = x.zeros_like(), v = x.zeros_like();
  std::vector<uint32_t> steps = std::vector<uint32_t>(x.size());

  blocks::AdamColumns columns(const SplatLayer& grad, const AttributeRates& rates) {
    blocks::AdamColumns c{};
    for (const AttributeRow& r : kAttributes) {
      const bool mean = r.id == Attribute::Mean;
      const bool shape = mean || r.id == Attribute::Rotation || r.id == Attribute::LogScale || r.id == Attribute::Opacity;
      c.column[size_t(r.id)] = {grad.values(r.id).data(),
                                m.values(r.id).data(),
                                v.values(r.id).data(),
                                x.values(r.id).data(),
                                uint32_t(x.width(r.id)),
                                rates[size_t(r.id)],
                                shape,
                                mean};
    }
    return c;
  }
};

TEST(AdamBlocks, TakesTheStepsOfTheCpu) {
  constexpr size_t kCount = 333;
  AttributeRates rates{};
  for (size_t a = 0; a < kAttributeCount; ++a) rates[a] = a == 6 ? 0.f : 0.01f * float(a + 1);
  SplatLayer cpu = noise(kCount, 1);
  Adam adam(cpu);
  BlockLayer in_order{cpu}, shuffled{cpu};
  BlockLoops loops, other(7);
  blocks::AdamBlocks<BlockLoops> adam_in_order(loops, {}), adam_shuffled(other, {});
  std::vector<uint8_t> active(kCount);
  std::vector<float> factors[3];
  for (uint64_t step = 0; step < 40; ++step) {
    SplatLayer grad = noise(kCount, 100 + step);
    grad.at(Attribute::LogScale, 5)[1] = std::numeric_limits<float>::quiet_NaN();
    grad.at(Attribute::Mean, 6)[0] = std::numeric_limits<float>::infinity();
    Rng rng(9, step);
    for (auto& a : active) a = rng.uniform() < 0.7f;
    active[5] = active[6] = 1;
    for (auto& f : factors) {
      f.resize(kCount);
      for (float& v : f) v = 0.5f + rng.uniform();
    }
    EXPECT_EQ(adam.step(grad, rates, active, cpu, {.all = factors[0], .shape = factors[1], .place = factors[2]}), 2u);
    const blocks::AdamFactors there{factors[0].data(), factors[1].data(), factors[2].data()};
    EXPECT_EQ(
        loops.read(adam_in_order.step(loops, in_order.columns(grad, rates), active.data(), there, in_order.steps.data(), kCount)),
        2u);
    adam_shuffled.step(other, shuffled.columns(grad, rates), active.data(), there, shuffled.steps.data(), kCount);
  }
  const SplatLayer start = noise(kCount, 1);
  double moved = 0;
  for (const AttributeRow& r : kAttributes)
    for (size_t i = 0; i < cpu.values(r.id).size(); ++i) {
      const float value = in_order.x.values(r.id)[i];
      ASSERT_EQ(value, shuffled.x.values(r.id)[i]);
      ASSERT_NEAR(value, cpu.values(r.id)[i], 3e-6) << r.name << " " << i;
      moved += std::abs(value - start.values(r.id)[i]);
    }
  EXPECT_GT(moved, 10.0);
  EXPECT_EQ(in_order.steps[5], 0u);
}

}  // namespace
}  // namespace vitrine
