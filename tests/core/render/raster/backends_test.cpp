// Back ends against the executable specification: tiny scenes x instruction sets and block kernels, images and gradients.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numeric>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/render/raster/renderer.h"
#include "tests/support/gradcheck.h"
#include "tests/support/tiny_scenes.h"

namespace vitrine {
namespace {

struct Pass {
  RasterImages images;
  SplatLayer grad;
  SurfelStatistics statistics;
};

// Upstream gradients of every channel, the same for every renderer.
RasterImages random_gradients(const RasterDesc& desc, uint64_t seed) {
  RasterImages g;
  g.reset(desc);
  Rng rng(seed);
  for (auto& plane : g.planes)
    for (float& v : plane) v = rng.normal();
  for (float& v : g.planes[static_cast<size_t>(Aov::Distortion)]) v *= 1000;
  return g;
}

Pass run(Renderer& renderer, const TinyScene& scene, const RasterImages& g) {
  Pass p;
  renderer.forward(scene.layer, scene.desc, p.images);
  std::vector<float> error(p.images.plane(Aov::Alpha).size());
  Rng rng(4);
  for (float& v : error) v = rng.uniform();
  p.grad = scene.layer.zeros_like();
  renderer.backward({.gradients = &g, .error_image = error}, p.grad, &p.statistics);
  return p;
}

Pass run(Renderer& renderer, const TinyScene& scene) { return run(renderer, scene, random_gradients(scene.desc, 3)); }

// A disc in a corner and single pixels here and there: tiles and blocks with all, some and none of their pixels.
std::vector<uint8_t> some_pixels(const Intrinsics& k) {
  std::vector<uint8_t> wanted;
  Rng rng(6);
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x)
      wanted.push_back(std::hypot(x - 0.3 * k.width, y - 0.6 * k.height) < 0.3 * k.height || rng.below(61) == 0);
  return wanted;
}

struct Column {
  const char* name;
  Backend backend;
  Simd simd;
};

class Backends : public testing::TestWithParam<Column> {
 protected:
  void SetUp() override {
    if (!machine_has(GetParam().simd)) GTEST_SKIP() << "this machine lacks the instruction set";
  }
  std::unique_ptr<Renderer> renderer() const { return make_renderer(GetParam().backend, GetParam().simd); }
};

TEST_P(Backends, AgreesWithTheReferenceOnEveryTinyScene) {
  const auto reference = make_renderer(Backend::Reference), fast = renderer();
  double worst_image = 0, worst_grad = 0, worst_statistic = 0;
  for (const TinyScene& scene : tiny_scenes()) {
    SCOPED_TRACE(scene.name);
    const Pass expected = run(*reference, scene), actual = run(*fast, scene);
    for (const AovRow& r : kAovs) {
      const auto e = expected.images.plane(r.id), a = actual.images.plane(r.id);
      ASSERT_EQ(e.size(), a.size());
      double worst = 0;
      for (size_t i = 0; i < e.size(); ++i) worst = std::max(worst, double(std::abs(e[i] - a[i])));
      EXPECT_LT(worst, 2e-5) << r.name;
      worst_image = std::max(worst_image, worst);
    }
    for (const AttributeRow& r : kAttributes) {
      const auto e = expected.grad.values(r.id), a = actual.grad.values(r.id);
      if (e.empty()) continue;
      const GradTolerance tolerance{.relative_l2 = 5e-5, .bias = 5e-5, .row_width = scene.layer.width(r.id)};
      const GradReport report = expect_grad_close(std::vector<float>(a.begin(), a.end()), std::vector<float>(e.begin(), e.end()),
                                                  tolerance, scene.name + " " + std::string(r.name));
      worst_grad = std::max(worst_grad, report.relative_l2);
    }
    const auto statistic = [&](const std::vector<float>& a, const std::vector<float>& e, const char* what) {
      worst_statistic = std::max(worst_statistic, expect_grad_close(a, e, {.relative_l2 = 5e-5, .bias = 5e-5}, what).relative_l2);
    };
    statistic(actual.statistics.weight, expected.statistics.weight, "weight");
    statistic(actual.statistics.error, expected.statistics.error, "error");
    statistic(actual.statistics.screen_gradient, expected.statistics.screen_gradient, "screen gradient");
  }
  std::cout << fast->numerics_tag() << " against reference: worst image difference " << worst_image
            << ", worst gradient relative L2 " << worst_grad << ", worst statistic " << worst_statistic << "\n";
}

// Wanted pixels are as in the whole picture, the others as before an empty scene; gradients are those of the whole picture with
// nothing asked of the others.
TEST_P(Backends, LeavesOutPixelsThatAreNotWanted) {
  for (const Backend backend : {Backend::Reference, GetParam().backend}) {
    const auto renderer = make_renderer(backend, GetParam().simd);
    TinyScene scene = cloud_scene("cloud", 300, 75, 53, 0.1, 0.8, 22);
    scene.desc.background = {0.1f, 0.2f, 0.3f};
    const std::vector<uint8_t> wanted = some_pixels(scene.desc.intrinsics);
    const size_t pixels = wanted.size();
    RasterImages upstream = random_gradients(scene.desc, 3);
    for (auto& plane : upstream.planes)
      for (size_t i = 0; i < plane.size(); ++i) plane[i] *= wanted[i % pixels];
    const Pass whole = run(*renderer, scene, upstream);
    scene.desc.wanted = wanted;
    const Pass part = run(*renderer, scene, random_gradients(scene.desc, 3));
    for (const AovRow& r : kAovs) {
      const auto w = whole.images.plane(r.id), p = part.images.plane(r.id);
      for (size_t i = 0; i < p.size(); ++i) {
        const float empty = r.id == Aov::Color ? scene.desc.background[i / pixels] : 0.f;
        ASSERT_NEAR(p[i], wanted[i % pixels] ? w[i] : empty, wanted[i % pixels] ? 1e-5 : 0) << r.name << " " << i;
      }
    }
    for (const AttributeRow& r : kAttributes) {
      const auto w = whole.grad.values(r.id), p = part.grad.values(r.id);
      if (w.empty()) continue;
      expect_grad_close(std::vector<float>(p.begin(), p.end()), std::vector<float>(w.begin(), w.end()),
                        {.relative_l2 = 5e-5, .bias = 5e-5, .row_width = scene.layer.width(r.id)}, std::string(r.name));
    }
    // What a surfel weighs and what it is to blame for is summed over the wanted pixels alone.
    EXPECT_LT(std::accumulate(part.statistics.weight.begin(), part.statistics.weight.end(), 0.0),
              0.5 * std::accumulate(whole.statistics.weight.begin(), whole.statistics.weight.end(), 0.0));
    scene.desc.wanted = {};
    const Pass again = run(*renderer, scene, upstream);
    EXPECT_EQ(again.images.planes, whole.images.planes);
    EXPECT_TRUE(again.grad == whole.grad);
  }
}

// The same specification for pictures of which a part is wanted, and for one of which nothing is.
TEST_P(Backends, AgreesWithTheReferenceOnWhatIsWanted) {
  const auto reference = make_renderer(Backend::Reference), fast = renderer();
  TinyScene scene = cloud_scene("cloud", 300, 75, 53, 0.1, 0.8, 22);
  const std::vector<uint8_t> some = some_pixels(scene.desc.intrinsics), none(some.size(), 0);
  scene.desc.wanted = some;
  const Pass expected = run(*reference, scene), actual = run(*fast, scene);
  for (const AovRow& r : kAovs) {
    const auto e = expected.images.plane(r.id), a = actual.images.plane(r.id);
    for (size_t i = 0; i < e.size(); ++i) ASSERT_NEAR(e[i], a[i], 2e-5) << r.name << " " << i;
  }
  const auto alike = [](std::span<const float> a, std::span<const float> e, size_t row_width, std::string_view what) {
    expect_grad_close(std::vector<float>(a.begin(), a.end()), std::vector<float>(e.begin(), e.end()),
                      {.relative_l2 = 5e-5, .bias = 5e-5, .row_width = row_width}, std::string(what));
  };
  for (const AttributeRow& r : kAttributes)
    if (!expected.grad.values(r.id).empty())
      alike(actual.grad.values(r.id), expected.grad.values(r.id), scene.layer.width(r.id), r.name);
  alike(actual.statistics.weight, expected.statistics.weight, 1, "weight");
  alike(actual.statistics.error, expected.statistics.error, 1, "error");
  alike(actual.statistics.screen_gradient, expected.statistics.screen_gradient, 1, "screen gradient");

  scene.desc.wanted = none;
  scene.desc.background = {};
  for (Renderer* renderer : {reference.get(), fast.get()}) {
    const Pass nothing = run(*renderer, scene);
    for (const auto& plane : nothing.images.planes)
      EXPECT_TRUE(std::ranges::all_of(plane, [](float v) { return v == 0; })) << renderer->name();
    EXPECT_TRUE(nothing.grad == scene.layer.zeros_like()) << renderer->name();
    EXPECT_EQ(renderer->counts().fragments, 0u);
  }
}

TEST_P(Backends, GivesTheSameBytesForOneTwoAndEightThreads) {
  const TinyScene scene = cloud_scene("cloud", 3000, 150, 110, 0.06, 0.9, 21);
  std::vector<Pass> passes;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    passes.push_back(run(*renderer(), scene));
  }
  set_thread_limit(0);
  for (size_t i = 1; i < passes.size(); ++i) {
    EXPECT_EQ(passes[0].images.planes, passes[i].images.planes);
    EXPECT_TRUE(passes[0].grad == passes[i].grad);
    EXPECT_EQ(passes[0].statistics.screen_gradient, passes[i].statistics.screen_gradient);
    EXPECT_EQ(passes[0].statistics.error, passes[i].statistics.error);
  }
}

INSTANTIATE_TEST_SUITE_P(Simd, Backends,
                         testing::Values(Column{"avx2", Backend::Cpu, Simd::Avx2}, Column{"avx512", Backend::Cpu, Simd::Avx512},
                                         Column{"blocks", Backend::Blocks, Simd::Best}),
                         [](const auto& info) { return info.param.name; });

}  // namespace
}  // namespace vitrine
