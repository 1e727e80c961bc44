// The losses of the picture as kernels for a GPU against those of the CPU.
#include "core/learn/loss/blocks/picture_loss_kernels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/learn/loss/test_frame.h"

namespace vitrine {
namespace {

using blocks::BlockLoops;

struct Evaluated {
  double l1, dssim;
  std::vector<float> gradient, error;
  bool operator==(const Evaluated&) const = default;
};

Evaluated of_blocks(const TestFrame& frame, const blocks::PictureLossWeights& weights, uint64_t seed) {
  BlockLoops loops(seed);
  blocks::PictureLossBlocks<BlockLoops> losses;
  const Intrinsics& k = frame.view.intrinsics;
  Evaluated e{0, 0, std::vector<float>(frame.prediction.size()), std::vector<float>(frame.prediction.size() / 3)};
  const blocks::PicturePair pair{frame.prediction.data(), frame.target.data(),
                                 frame.weight.empty() ? nullptr : frame.weight.data(), uint32_t(k.width), uint32_t(k.height)};
  losses.evaluate(loops, pair, weights, e.gradient.data(), e.error.data());
  const auto values = losses.values(loops);
  e.l1 = values.l1;
  e.dssim = values.dssim;
  return e;
}

Evaluated of_cpu(const TestFrame& frame, const blocks::PictureLossWeights& weights) {
  Evaluated e{0, 0, std::vector<float>(frame.prediction.size()), std::vector<float>(frame.prediction.size() / 3)};
  const LossInput input{
      .view = &frame.view, .prediction_srgb = frame.prediction, .target_srgb = frame.target, .weight = frame.weight};
  LossGradient gradient{.prediction_srgb = e.gradient};
  for (const LossFactory& f : loss_registry()) {
    if (f.name == "l1") e.l1 = f.make()->evaluate(input, weights.l1, gradient);
    if (f.name == "dssim") e.dssim = f.make()->evaluate(input, weights.dssim, gradient);
  }
  const size_t pixels = e.error.size();
  for (size_t i = 0; i < 3 * pixels; ++i)
    e.error[i % pixels] +=
        std::abs(frame.prediction[i] - frame.target[i]) / 3 * (frame.weight.empty() ? 1 : frame.weight[i % pixels]);
  return e;
}

TEST(PictureLossBlocks, AgreeWithTheCpuInAnyOrder) {
  for (const auto& [width, height] : {std::pair{53, 38}, std::pair{16, 16}, std::pair{5, 3}})
    for (const bool weighted : {false, true}) {
      SCOPED_TRACE(width);
      const TestFrame frame(width, height, weighted, 4);
      const blocks::PictureLossWeights weights{0.8f, 0.2f};
      const Evaluated cpu = of_cpu(frame, weights), there = of_blocks(frame, weights, 0);
      EXPECT_EQ(of_blocks(frame, weights, 11), there);
      EXPECT_GT(cpu.dssim, 1e-3);
      EXPECT_NEAR(there.l1, cpu.l1, 1e-6 * cpu.l1);
      EXPECT_NEAR(there.dssim, cpu.dssim, 2e-6 * cpu.dssim);
      double largest = 0;
      for (const float g : cpu.gradient) largest = std::max(largest, double(std::abs(g)));
      for (size_t i = 0; i < cpu.gradient.size(); ++i) ASSERT_NEAR(there.gradient[i], cpu.gradient[i], 3e-5 * largest) << i;
      for (size_t i = 0; i < cpu.error.size(); ++i) ASSERT_NEAR(there.error[i], cpu.error[i], 1e-6) << i;
    }
}

TEST(PictureLossBlocks, APictureOfWeightZeroHasNoGradient) {
  TestFrame frame(20, 20, true, 4);
  std::fill(frame.weight.begin(), frame.weight.end(), 0.f);
  const Evaluated there = of_blocks(frame, {0.8f, 0.2f}, 0);
  EXPECT_EQ(there.l1 + there.dssim, 0);
  for (const float g : there.gradient) ASSERT_EQ(g, 0.f);
}

TEST(PictureLossBlocks, TreeSumsAddEveryNumberOnce) {
  for (const uint32_t size : {0u, 1u, 2048u, 2049u, 70000u}) {
    BlockLoops loops;
    blocks::TreeSumMemory<BlockLoops> memory;
    std::vector<float> values(size);
    for (uint32_t i = 0; i < size; ++i) values[i] = float(i % 13);
    double expected = 0;
    for (const float v : values) expected += v;
    EXPECT_EQ(loops.read(blocks::tree_sum(loops, memory, values.data(), size)), expected);
  }
}

}  // namespace
}  // namespace vitrine
