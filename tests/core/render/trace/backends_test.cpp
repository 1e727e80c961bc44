// The tracers for production against the executable specification, exact order, long lists, threads; and against the
// rasteriser.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iostream>

#include "core/foundation/base/parallel.h"
#include "tests/core/render/trace/ray_scenes.h"
#include "tests/support/gradcheck.h"

namespace vitrine {
namespace {

double worst_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double worst = a.size() == b.size() ? 0 : 1e30;
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i) worst = std::max(worst, double(std::abs(a[i] - b[i])));
  return worst;
}

class Backends : public testing::TestWithParam<TracerBackend> {};
INSTANTIATE_TEST_SUITE_P(Tracers, Backends, testing::Values(TracerBackend::Embree, TracerBackend::Blocks),
                         [](const auto& backend) { return backend.param == TracerBackend::Embree ? "Embree" : "Blocks"; });

TEST_P(Backends, AgreesWithTheReferenceOnEveryScene) {
  const auto reference = make_tracer(TracerBackend::Reference), tracer = make_tracer(GetParam());
  double worst_value = 0, worst_grad = 0;
  for (const RayScene& scene : ray_scenes()) {
    SCOPED_TRACE(scene.name);
    const TracePass e = run(*reference, scene), a = run(*tracer, scene);
    const auto value = [&](const std::vector<float>& x, const std::vector<float>& y, const char* what) {
      const double d = worst_difference(x, y);
      EXPECT_LT(d, 2e-5) << what;
      worst_value = std::max(worst_value, d);
    };
    value(flat(a.values.color), flat(e.values.color), "color");
    value(a.values.transmittance, e.values.transmittance, "transmittance");
    value(a.values.distance, e.values.distance, "distance");
    value(a.values.first_hit, e.values.first_hit, "first hit");
    value(flat(a.values.normal), flat(e.values.normal), "normal");
    ASSERT_EQ(a.hits.size(), e.hits.size());
    for (size_t i = 0; i < scene.origins.size(); ++i)
      for (size_t h = 0; h < e.hits.of(i).size(); ++h) EXPECT_EQ(a.hits.of(i)[h].surfel, e.hits.of(i)[h].surfel);
    const auto grad = [&](const std::vector<float>& x, const std::vector<float>& y, size_t width, const std::string& what) {
      const GradTolerance t{.relative_l2 = 5e-5, .bias = 5e-5, .row_width = width};
      worst_grad = std::max(worst_grad, expect_grad_close(x, y, t, scene.name + " " + what).relative_l2);
    };
    for (const AttributeRow& r : kAttributes) {
      const auto x = a.grad.values(r.id), y = e.grad.values(r.id);
      if (!y.empty()) grad({x.begin(), x.end()}, {y.begin(), y.end()}, scene.layer.width(r.id), std::string(r.name));
    }
    grad(flat(a.rays.origins), flat(e.rays.origins), 3, "origins");
    grad(flat(a.rays.directions), flat(e.rays.directions), 3, "directions");
    grad(a.statistics.weight, e.statistics.weight, 1, "weight");
    grad(a.statistics.error, e.statistics.error, 1, "error");
    grad(a.statistics.screen_gradient, e.statistics.screen_gradient, 1, "screen gradient");
  }
  std::cout << tracer->name() << " against reference: worst value difference " << worst_value << ", worst gradient relative L2 "
            << worst_grad << "\n";
}

TEST_P(Backends, OrdersCoplanarSurfelsByIndex) {
  RayScene s;
  for (uint64_t i = 0; i < 40; ++i) add_surfel(s, {.mean = {0, 0, 1}, .su = 0.3, .sv = 0.3, .opacity = 0.3}, i);
  // Exactly the same plane: one rotation for all.
  for (size_t i = 1; i < s.layer.size(); ++i)
    std::copy_n(s.layer.at(Attribute::Rotation, 0), 4, s.layer.at(Attribute::Rotation, i));
  for (int i = 0; i < 30; ++i) s.add_ray({0.01 * i, 0.02, 0}, {0.002 * i, 0, 1});
  s.desc.min_transmittance = 1e-6f;
  const TracePass a = run(*make_tracer(GetParam()), s), e = run(*make_tracer(TracerBackend::Reference), s);
  for (size_t i = 0; i < s.origins.size(); ++i) {
    const auto hits = a.hits.of(i);
    ASSERT_GT(hits.size(), 20u);
    for (size_t h = 0; h < hits.size(); ++h) {
      EXPECT_EQ(hits[h].surfel, h);
      EXPECT_EQ(hits[h].t, hits[0].t);
    }
  }
  EXPECT_LT(worst_difference(flat(a.values.color), flat(e.values.color)), 1e-5);
}

TEST_P(Backends, TakesHundredsOfHitsInOrder) {
  RayScene s;
  for (uint64_t i = 0; i < 600; ++i)
    add_surfel(
        s, {.mean = {0, 0, 1 + 0.002 * double((i * 277) % 600)}, .normal = {0.05, 0, 1}, .su = 2, .sv = 2, .opacity = 0.01}, i);
  for (int i = 0; i < 20; ++i) s.add_ray({0.02 * i, 0, 0}, {0, 0.01 * i, 1});
  const TracePass a = run(*make_tracer(GetParam()), s), e = run(*make_tracer(TracerBackend::Reference), s);
  for (size_t i = 0; i < s.origins.size(); ++i) {
    const auto hits = a.hits.of(i);
    EXPECT_EQ(hits.size(), 600u);
    for (size_t h = 1; h < hits.size(); ++h) EXPECT_LT(hits[h - 1].t, hits[h].t);
  }
  EXPECT_LT(worst_difference(flat(a.values.color), flat(e.values.color)), 2e-5);
  EXPECT_LT(worst_difference(a.values.transmittance, e.values.transmittance), 1e-6);
}

TEST_P(Backends, GivesTheSameBytesForOneTwoAndEightThreads) {
  const RayScene s = ray_cloud("cloud", 4000, 3000, 0.05, 0.6, 31);
  std::vector<TracePass> passes;
  for (int threads : {1, 2, 8}) {
    set_thread_limit(threads);
    passes.push_back(run(*make_tracer(GetParam()), s));
  }
  set_thread_limit(0);
  EXPECT_GT(passes[0].hits.size(), 20000u);
  for (size_t i = 1; i < passes.size(); ++i) {
    EXPECT_EQ(flat(passes[0].values.color), flat(passes[i].values.color));
    EXPECT_EQ(passes[0].values.distance, passes[i].values.distance);
    EXPECT_TRUE(passes[0].grad == passes[i].grad);
    EXPECT_EQ(flat(passes[0].rays.directions), flat(passes[i].rays.directions));
    EXPECT_EQ(passes[0].statistics.screen_gradient, passes[i].statistics.screen_gradient);
  }
}

// The tree may take any shape: the same surfels in another order in it, by a batch of others that nobody sees.
TEST_P(Backends, GivesTheSameBytesForAnotherTree) {
  RayScene s = ray_cloud("cloud", 2000, 800, 0.08, 0.7, 32);
  const TracePass plain = run(*make_tracer(GetParam()), s);
  const size_t n = s.layer.size();
  for (uint64_t i = 0; i < 500; ++i) add_surfel(s, {.mean = {50.0 + double(i), 0, 0}, .su = 5, .sv = 5}, i);
  const auto far_away = run(*make_tracer(GetParam()), [&] {
    RayScene limited = s;
    limited.far.assign(s.origins.size(), 20.f);
    return limited;
  }());
  EXPECT_EQ(flat(plain.values.color), flat(far_away.values.color));
  for (Attribute a : {Attribute::Mean, Attribute::Rotation, Attribute::ShRest}) {
    const auto x = plain.grad.values(a), y = far_away.grad.values(a).first(n * s.layer.width(a));
    EXPECT_TRUE(std::equal(x.begin(), x.end(), y.begin(), y.end()));
  }
}

TEST_P(Backends, EmptyLayersNoRaysAndBrokenValuesAreHarmless) {
  const auto tracer = make_tracer(GetParam());
  RayScene s;
  s.add_ray({0, 0, 0}, {0, 0, 1});
  EXPECT_EQ(run(*tracer, s).values.transmittance[0], 1.f);
  add_surfel(s, {.mean = {0, 0, 1}}, 1);
  add_surfel(s, {.mean = {0, 0, 2}}, 2);
  s.layer.at(Attribute::Mean, 0)[1] = std::numeric_limits<float>::quiet_NaN();
  const TracePass p = run(*tracer, s);
  ASSERT_EQ(p.hits.size(), 1u);
  EXPECT_EQ(p.hits.of(0)[0].surfel, 1u);
  s.origins.clear();
  s.directions.clear();
  EXPECT_TRUE(run(*tracer, s).values.color.empty());
}

// Primary rays through both: without the screen low-pass and with colour that does not depend on the direction (the rasteriser
// takes it towards the mean, the tracer along the ray), rasteriser and tracer form the same picture. In another scene a hit may
// lie so close to the cut at 1/255 or to another hit that rounding decides; then a pixel differs by a fraction of one step of
// 255.
TEST_P(Backends, PrimaryRaysGiveThePictureOfTheRasteriser) {
  TinyScene picture = cloud_scene("primary", 400, 96, 80, 0.25, 0.8, 42);
  picture.desc.low_pass = false;
  picture.desc.sh_degree = 0;
  picture.desc.background = {0, 0, 0};
  RasterImages raster;
  make_renderer(Backend::Cpu)->forward(picture.layer, picture.desc, raster);
  RayScene s;
  s.layer = picture.layer;
  s.desc = {.sh_degree = 0, .min_transmittance = 1e-4f};
  const Intrinsics& k = picture.desc.intrinsics;
  const Rigid world_from_cam = inverse(picture.desc.cam_from_world);
  std::vector<double> z_of_t;
  for (int y = 0; y < k.height; ++y)
    for (int x = 0; x < k.width; ++x) {
      const Vec3d d = k.ray(x + 0.5, y + 0.5);
      s.add_ray(world_from_cam.translation, world_from_cam.rotation * d);
      s.near.push_back(picture.desc.near_z * float(length(d)));
      z_of_t.push_back(1 / length(d));
    }
  RayValues traced;
  const auto tracer = make_tracer(GetParam());
  tracer->build(s.layer);
  tracer->forward(s.rays(), s.desc, traced, nullptr);
  const size_t n = s.origins.size();
  double color = 0, normal = 0, alpha = 0, depth = 0, covered = 0;
  for (size_t i = 0; i < n; ++i) {
    for (size_t c = 0; c < 3; ++c) {
      color = std::max(color, double(std::abs(raster.plane(Aov::Color)[c * n + i] - traced.color[i][c])));
      normal = std::max(normal, double(std::abs(raster.plane(Aov::Normal)[c * n + i] - traced.normal[i][c])));
    }
    alpha = std::max(alpha, double(std::abs(raster.plane(Aov::Alpha)[i] - (1 - traced.transmittance[i]))));
    depth = std::max(depth, std::abs(double(raster.plane(Aov::ZDepth)[i]) - z_of_t[i] * double(traced.distance[i])));
    covered += raster.plane(Aov::Alpha)[i] > 0.5f;
  }
  EXPECT_GT(covered, 0.5 * double(n));
  EXPECT_LT(color, 1e-4);
  EXPECT_LT(normal, 1e-4);
  EXPECT_LT(alpha, 1e-4);
  EXPECT_LT(depth, 1e-4);
  std::cout << "raster against " << tracer->name() << ": color " << color << ", normal " << normal << ", alpha " << alpha
            << ", depth " << depth << "\n";
}

}  // namespace
}  // namespace vitrine
