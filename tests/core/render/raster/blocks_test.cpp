// Renderer "blocks" (the kernels for a GPU, run as loops) against the executable specification, and against itself in other
// orders of its blocks and threads; its scan and its sort against those of the standard library.
#include <gtest/gtest.h>

#include <algorithm>
#include <barrier>
#include <cmath>
#include <iostream>
#include <numeric>
#include <thread>

#include "core/foundation/base/hash.h"
#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/renderer.h"
#include "tests/support/tiny_scenes.h"

namespace vitrine {
namespace {

using blocks::BlockLoops;

RasterImages rendered(Renderer& renderer, const TinyScene& scene) {
  RasterImages images;
  renderer.forward(scene.layer, scene.desc, images);
  return images;
}

// Planes, gradients and statistics of a forward and a reverse pass.
std::vector<std::vector<float>> passes(Renderer& renderer, const TinyScene& scene) {
  const RasterImages images = rendered(renderer, scene);
  RasterImages upstream;
  upstream.reset(scene.desc);
  Rng rng(3);
  for (auto& plane : upstream.planes)
    for (float& v : plane) v = rng.uniform() - 0.5f;
  SplatLayer grad = scene.layer.zeros_like();
  SurfelStatistics statistics;
  const auto error = images.plane(Aov::Alpha);
  renderer.backward({.gradients = &upstream, .error_image = error}, grad, &statistics);
  std::vector<std::vector<float>> all(images.planes.begin(), images.planes.end());
  for (const AttributeRow& r : kAttributes) all.emplace_back(grad.values(r.id).begin(), grad.values(r.id).end());
  for (const auto* v : {&statistics.screen_gradient, &statistics.weight, &statistics.error}) all.push_back(*v);
  return all;
}

// Largest difference to the reference; each plane stays below the bound of the CPU renderer (backends_test.cpp).
double expect_reference(Renderer& renderer, const TinyScene& scene) {
  SCOPED_TRACE(scene.name);
  const RasterImages expected = rendered(*make_renderer(Backend::Reference), scene), actual = rendered(renderer, scene);
  double worst_of_all = 0;
  for (const AovRow& r : kAovs) {
    const auto e = expected.plane(r.id), a = actual.plane(r.id);
    EXPECT_EQ(e.size(), a.size()) << r.name;
    double worst = 0;
    for (size_t i = 0; i < std::min(e.size(), a.size()); ++i) worst = std::max(worst, double(std::abs(e[i] - a[i])));
    EXPECT_LT(worst, 2e-5) << r.name;
    worst_of_all = std::max(worst_of_all, worst);
  }
  return worst_of_all;
}

// Surfels that cross each other in every pixel: more fragments wait for their order than a pixel has registers for.
TinyScene crossing_scene() {
  TinyScene s = empty_scene("crossing", 45, 38);
  for (uint64_t i = 0; i < 40; ++i)
    add_surfel(s,
               {.mean = {0.01 * double(i % 7) - 0.03, 0.01 * double(i % 5) - 0.02, 2 + 0.001 * double(i)},
                .angle_x = 1.2 * std::sin(double(i)),
                .angle_y = 1.2 * std::cos(1.7 * double(i)),
                .su = 0.5,
                .sv = 0.5,
                .opacity = 0.12},
               i + 1);
  return s;
}

TEST(Blocks, AgreesWithTheReferenceForEverySetOfChannels) {
  const auto renderer = make_renderer(Backend::Blocks);
  TinyScene scene = cloud_scene("cloud", 100, 45, 38, 0.1, 0.8, 22);
  for (const FeatureSet features : {FeatureSet::ColorOnly, FeatureSet::Surface, FeatureSet::Material})
    for (const bool distortion : {false, true})
      for (const int degree : {0, 1, 2, 3}) {
        scene.desc.features = features;
        scene.desc.distortion = distortion;
        scene.desc.sh_degree = degree;
        expect_reference(*renderer, scene);
      }
}

// A sweep evaluates each instance at most once for each of the 256 pixels of its tile.
TEST(Blocks, SweepsAgainWhereMoreFragmentsWaitThanAPixelHolds) {
  const auto renderer = make_renderer(Backend::Blocks);
  expect_reference(*renderer, crossing_scene());
  EXPECT_GT(renderer->counts().lanes, 256 * renderer->counts().instances);
  TinyScene apart = empty_scene("apart");
  for (uint64_t i = 0; i < 40; ++i)
    add_surfel(apart, {.mean = {0, 0, 2 + 0.1 * double(i)}, .angle_x = 0.1, .su = 0.3, .sv = 0.3, .opacity = 0.12}, i);
  expect_reference(*renderer, apart);
  EXPECT_LE(renderer->counts().lanes, 256 * renderer->counts().instances);
  EXPECT_GT(renderer->counts().fragments, 0u);
}

// The first surfel is in front where depths are equal.
TEST(Blocks, AgreesWithTheReferenceWhereDepthsAreEqual) {
  TinyScene scene = empty_scene("equal");
  for (uint64_t i = 0; i < 12; ++i) {
    add_surfel(scene, {.mean = {0.05, -0.1, 2}, .angle_x = 0.4, .su = 0.4, .sv = 0.3, .opacity = 0.4}, i);
    if (i > 0) scene.layer.copy_surfel(0, i);
    for (size_t c = 0; c < 3; ++c) scene.layer.at(Attribute::ShDc, i)[c] = (i + c) % 3 == 0 ? 2.f : -1.f;
  }
  expect_reference(*make_renderer(Backend::Blocks), scene);
}

// Runs the threads of a block at the same time, with barriers between phases, as a device does. Under ThreadSanitizer it finds
// values that one thread of a phase reads or writes while another writes them.
struct BlockThreads : BlockLoops {
  template <class Kernel>
  void launch(const Kernel& kernel, uint32_t blocks) {
    std::vector<typename Kernel::Shared> shared(blocks);
    std::barrier barrier(Kernel::kThreads);
    std::vector<std::jthread> threads;
    for (uint32_t t = 0; t < Kernel::kThreads; ++t)
      threads.emplace_back([&, t] {
        for (uint32_t block = 0; block < blocks; ++block) {
          typename Kernel::Thread own;
          for (uint32_t phase = 0; kernel.has_phase(phase, shared[block]); ++phase) {
            kernel.run(phase, {block, t}, own, shared[block]);
            barrier.arrive_and_wait();
          }
        }
      });
  }
};

TEST(Blocks, GivesTheSameBytesWithThreadsAndBarriers) {
  const TinyScene scene = cloud_scene("cloud", 150, 37, 29, 0.3, 0.3, 9);
  const auto threads = make_blocks_renderer(std::make_unique<blocks::ExecutorPass<BlockThreads>>(BlockThreads()));
  const auto loops = make_blocks_renderer(1);  // in the calling thread
  EXPECT_EQ(passes(*threads, scene), passes(*loops, scene));
  EXPECT_EQ(threads->counts().lanes, loops->counts().lanes);
}

TEST(Blocks, GivesTheSameBytesInAnyOrderOfBlocksAndThreads) {
  for (const TinyScene& scene : {cloud_scene("cloud", 300, 75, 45, 0.1, 0.9, 21), crossing_scene()}) {
    SCOPED_TRACE(scene.name);
    const auto in_order = make_blocks_renderer();
    const auto expected = passes(*in_order, scene);
    for (const uint64_t seed : {1, 2, 3}) {
      const auto shuffled = make_blocks_renderer(seed);
      EXPECT_EQ(passes(*shuffled, scene), expected) << "seed " << seed;
      EXPECT_EQ(shuffled->counts().lanes, in_order->counts().lanes);
    }
  }
}

// Values that need no function of a library.
TinyScene arithmetic_scene() {
  TinyScene s = empty_scene("arithmetic", 75, 53);
  s.desc.cam_from_world = {Mat3d::identity(), {0, 0, 3}};
  s.layer.resize(500);
  Rng rng(5);
  const auto fill = [&](Attribute a, float from, float factor) {
    for (float& v : s.layer.values(a)) v = (rng.uniform() - from) * factor;
  };
  fill(Attribute::Mean, 0.5f, 3);
  fill(Attribute::Rotation, 0.5f, 2);
  fill(Attribute::LogScale, 3, 1);
  fill(Attribute::Opacity, 0.3f, 4);
  fill(Attribute::ShDc, 0.5f, 2);
  fill(Attribute::ShRest, 0.5f, 0.5f);
  for (const Attribute a : {Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight, Attribute::Transmission})
    fill(a, 0.5f, 4);
  return s;
}

// The bytes are those of every compiler and device: no product is contracted, no function is a library's. Other kernels on
// purpose: another digest, and another numerics_tag.
TEST(Blocks, GivesTheBytesOfItsTag) {
  const TinyScene scene = arithmetic_scene();
  const auto renderer = make_renderer(Backend::Blocks);
  expect_reference(*renderer, scene);
  Hasher planes, gradients;
  const auto all = passes(*renderer, scene);
  for (size_t i = 0; i < all.size(); ++i) (i < kAovCount ? planes : gradients).add(std::as_bytes(std::span(all[i])));
  EXPECT_EQ(renderer->numerics_tag(), "cuda-2");
  EXPECT_GT(renderer->counts().fragments, 10000u);
  EXPECT_EQ(planes.digest().short_hex(), "39a98ce03399");
  EXPECT_EQ(gradients.digest().short_hex(), "b8eb830e7bf0");
}

TEST(Blocks, GivesTheSameBytesForAnyNumberOfThreadsAndFromCallToCall) {
  const TinyScene scene = cloud_scene("cloud", 800, 100, 70, 0.06, 0.9, 21),
                  other = cloud_scene("other", 90, 33, 20, 0.2, 0.9, 5);
  const auto renderer = make_renderer(Backend::Blocks);
  std::vector<std::vector<std::vector<float>>> results;
  for (const int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    results.push_back(passes(*renderer, scene));
    passes(*renderer, other);  // leaves its values in the arrays
  }
  set_thread_limit(0);
  EXPECT_EQ(results[0], results[1]);
  EXPECT_EQ(results[0], results[2]);
}

TEST(Blocks, LeavesOutPixelsThatAreNotWanted) {
  const auto renderer = make_renderer(Backend::Blocks);
  TinyScene scene = cloud_scene("cloud", 300, 75, 53, 0.1, 0.8, 22);
  std::vector<uint8_t> wanted(scene.desc.intrinsics.pixel_count());
  Rng rng(6);
  for (uint8_t& w : wanted) w = rng.below(3) == 0;
  const RasterImages whole = rendered(*renderer, scene);
  scene.desc.wanted = wanted;
  expect_reference(*renderer, scene);
  const RasterImages part = rendered(*renderer, scene);
  for (size_t i = 0; i < wanted.size(); ++i)
    EXPECT_EQ(part.plane(Aov::Alpha)[i], wanted[i] != 0 ? whole.plane(Aov::Alpha)[i] : 0.f);
  std::fill(wanted.begin(), wanted.end(), uint8_t{0});
  expect_reference(*renderer, scene);
  EXPECT_EQ(renderer->counts().fragments, 0u);
}

TEST(Blocks, RendersABackgroundWithoutSurfels) {
  const auto renderer = make_renderer(Backend::Blocks);
  EXPECT_EQ(expect_reference(*renderer, empty_scene("empty")), 0);
  TinyScene behind = empty_scene("behind");
  add_surfel(behind, {.mean = {0, 0, -2}}, 1);
  EXPECT_EQ(expect_reference(*renderer, behind), 0);
  const auto all = passes(*renderer, behind);
  for (size_t i = kAovCount; i < all.size(); ++i)
    for (const float v : all[i]) EXPECT_EQ(v, 0);
}

TEST(Blocks, ScansAndSortsLikeTheStandardLibrary) {
  for (const uint64_t seed : {0, 7})
    for (const uint32_t size : {0u, 1u, 255u, 2048u, 2049u, 9001u}) {
      SCOPED_TRACE(size);
      BlockLoops loops(seed);
      Rng rng(3, size);
      std::vector<uint32_t> values(size), expected(size), out(size);
      for (uint32_t& v : values) v = rng.below(1000);
      std::exclusive_scan(values.begin(), values.end(), expected.begin(), 0u);
      blocks::ScanMemory<BlockLoops> scan;
      const uint32_t* total = blocks::exclusive_scan(loops, scan, values.data(), out.data(), size);
      EXPECT_EQ(out, expected);
      EXPECT_EQ(loops.read(total), std::accumulate(values.begin(), values.end(), 0u));

      // Few different keys: equal ones must stay in order. Bits outside of those that are sorted by are ignored.
      blocks::SortMemory<BlockLoops> sort;
      sort.resize(size);
      std::vector<std::pair<uint64_t, uint32_t>> pairs(size);
      for (uint32_t i = 0; i < size; ++i) {
        pairs[i] = {uint64_t{rng.below(300)} << 30 | rng.below(256), i};
        sort.keys[i] = pairs[i].first;
        sort.values[i] = i;
      }
      std::stable_sort(pairs.begin(), pairs.end(), [](const auto& a, const auto& b) { return a.first >> 8 < b.first >> 8; });
      const blocks::SortedPairs sorted = blocks::radix_sort(loops, sort, size, 8, 40);
      for (uint32_t i = 0; i < size; ++i) {
        ASSERT_EQ(sorted.keys[i], pairs[i].first) << i;
        ASSERT_EQ(sorted.values[i], pairs[i].second) << i;
      }
    }
}

TEST(Blocks, FunctionsOfFloatsAreAccurateAndRoundOnce) {
  using blocks::F32;
  for (float x = -80; x < 80; x += 0.37f) {
    EXPECT_NEAR(exp(F32(x)).v / std::exp(double(x)), 1, 1e-5) << x;  // the product with 1/ln 2 is rounded
    EXPECT_NEAR(gaussian(F32(std::abs(x))).v, std::exp(-0.5 * std::abs(double(x))), 3e-7) << x;
    EXPECT_NEAR(log_of(F32(std::exp(x))).v, x, 2e-5) << x;
    const float power = std::exp(x), near_one = 1 + 0.01f * x;
    EXPECT_NEAR(log(F32(power)).v / std::log(double(power)), 1, 3e-7) << x;
    EXPECT_NEAR(log(F32(near_one)).v / std::log(double(near_one)), 1, 3e-7) << x;
  }
  // A product that is rounded before the sum, and one that is not: (1 + e)^2 - 1 - 2 e.
  const volatile float e = 0x1p-13f;
  const F32 a(1.f + e), b(-(1.f + 2 * e));
  EXPECT_EQ((a * a + b).v, 0.f);
  EXPECT_EQ(fma(a, a, b).v, e * e);
}

}  // namespace
}  // namespace vitrine
