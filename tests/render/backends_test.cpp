// The CPU back end against the executable specification: tiny scenes x instruction sets, images and gradients.
#include <gtest/gtest.h>

#include <iostream>

#include "core/base/parallel.h"
#include "core/base/rng.h"
#include "core/render/renderer.h"
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

Pass run(Renderer& renderer, const TinyScene& scene) {
  Pass p;
  renderer.forward(scene.layer, scene.desc, p.images);
  const RasterImages g = random_gradients(scene.desc, 3);
  std::vector<float> error(p.images.plane(Aov::Alpha).size());
  Rng rng(4);
  for (float& v : error) v = rng.uniform();
  p.grad = scene.layer.zeros_like();
  renderer.backward({.gradients = &g, .error_image = error}, p.grad, &p.statistics);
  return p;
}

class Backends : public testing::TestWithParam<Simd> {
 protected:
  void SetUp() override {
    if (!machine_has(GetParam())) GTEST_SKIP() << "this machine lacks the instruction set";
  }
};

TEST_P(Backends, AgreesWithTheReferenceOnEveryTinyScene) {
  const auto reference = make_renderer(Backend::Reference), cpu = make_renderer(Backend::Cpu, GetParam());
  double worst_image = 0, worst_grad = 0, worst_statistic = 0;
  for (const TinyScene& scene : tiny_scenes()) {
    SCOPED_TRACE(scene.name);
    const Pass expected = run(*reference, scene), actual = run(*cpu, scene);
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
  std::cout << cpu->numerics_tag() << " against reference: worst image difference " << worst_image
            << ", worst gradient relative L2 " << worst_grad << ", worst statistic " << worst_statistic << "\n";
}

TEST_P(Backends, GivesTheSameBytesForOneTwoAndEightThreads) {
  const TinyScene scene = cloud_scene("cloud", 3000, 150, 110, 0.06, 0.9, 21);
  std::vector<Pass> passes;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    const auto cpu = make_renderer(Backend::Cpu, GetParam());
    passes.push_back(run(*cpu, scene));
  }
  set_thread_limit(0);
  for (size_t i = 1; i < passes.size(); ++i) {
    EXPECT_EQ(passes[0].images.planes, passes[i].images.planes);
    EXPECT_TRUE(passes[0].grad == passes[i].grad);
    EXPECT_EQ(passes[0].statistics.screen_gradient, passes[i].statistics.screen_gradient);
    EXPECT_EQ(passes[0].statistics.error, passes[i].statistics.error);
  }
}

INSTANTIATE_TEST_SUITE_P(Simd, Backends, testing::Values(Simd::Avx2, Simd::Avx512),
                         [](const auto& info) { return info.param == Simd::Avx2 ? "avx2" : "avx512"; });

}  // namespace
}  // namespace vitrine
