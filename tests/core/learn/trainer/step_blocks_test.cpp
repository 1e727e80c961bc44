// Training steps as kernels for a GPU: they learn, and their bytes depend on no order of blocks and threads.
#include "core/learn/trainer/blocks/step_blocks.h"

#include <gtest/gtest.h>

#include "core/foundation/base/hash.h"
#include "core/foundation/math/color.h"
#include "tests/support/block_steps.h"

namespace vitrine {
namespace {

using blocks::BlockLoops;

TEST(StepBlocks, LearnInAnyOrderOfBlocksAndThreads) {
  test::StepScene scene(60, 40, 32, 2);
  std::string digests[2];
  for (const uint64_t seed : {0, 1}) {
    blocks::StepBlocks<BlockLoops> steps{BlockLoops(seed)};
    const auto photos = scene.start(steps);
    std::vector<double> losses;
    test::take_steps(steps, scene, photos, 20, &losses);
    const auto counts = steps.relocate(1, 20, 0.02, 1.2, 66);
    EXPECT_EQ(counts.added, 6u);
    EXPECT_EQ(steps.surfels(), 66u);
    steps.walk(10.f, 1, 20);
    test::take_steps(steps, scene, photos, 30, &losses);
    EXPECT_LT(losses.back(), 0.6 * losses.front());
    Hasher hasher;
    for (const auto& column : test::surfel_values(steps)) hasher.add(std::as_bytes(std::span(column)));
    digests[seed] = hasher.digest().short_hex();
  }
  EXPECT_EQ(digests[0], digests[1]);
  // Of every compiler and device, as in blocks_test.cpp.
  EXPECT_EQ(digests[0], "77bc4a6a3d57");
}

TEST(DisplayBlocks, AreSrgbAndItsSlope) {
  BlockLoops loops;
  constexpr uint32_t kPixels = 500;
  std::vector<float> linear(3 * kPixels), srgb(3 * kPixels), gradient(3 * kPixels, 1.f);
  for (size_t i = 0; i < linear.size(); ++i)
    linear[i] = -0.1f + 1.3f * float(i % kPixels) * float(i % kPixels) / (kPixels * kPixels);
  const float gain[] = {1.f, 0.8f, 1.1f};
  loops.launch(blocks::DisplayKernel{linear.data(), srgb.data(), {gain[0], gain[1], gain[2]}, kPixels},
               blocks::blocks_for(kPixels, 128));
  loops.launch(blocks::DisplayReverseKernel{linear.data(), gradient.data(), {gain[0], gain[1], gain[2]}, kPixels},
               blocks::blocks_for(kPixels, 128));
  for (size_t i = 0; i < linear.size(); ++i) {
    // Of a clipped value only what moves it back into range.
    const double g = gain[i / kPixels], l = g * linear[i], seen = l >= 0 ? 1 : 0;
    ASSERT_NEAR(srgb[i], srgb_from_linear(std::clamp(l, 0.0, 1.0)), 5e-7) << l;
    ASSERT_NEAR(gradient[i], g * seen * srgb_from_linear_slope(std::clamp(l, 0.0, 1.0)), 1e-5) << l;
  }
}

}  // namespace
}  // namespace vitrine
