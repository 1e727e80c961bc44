// Relighting: drawing directions from an environment, shadow rays, light on a mesh, and whole pictures. A matt ball of 100k faces
// stands for the scene, under a map of 1024x512 with a sun.
#include <benchmark/benchmark.h>

#include <cmath>
#include <numbers>

#include "core/foundation/base/rng.h"
#include "core/render/relight/light_transfer.h"
#include "core/render/relight/relit_painter.h"
#include "core/render/relight/sample_points.h"
#include "tests/support/tiny_capture.h"

namespace vitrine {
namespace {

Environment sunny() {
  ImageF map(1024, 512, 3, 0.5f);
  for (int y = 100; y < 110; ++y)
    for (int x = 300; x < 310; ++x)
      for (int c = 0; c < 3; ++c) map.at(x, y, c) = 2000;
  return Environment(std::move(map));
}

RelitScene ball(uint32_t rings) {
  RelitScene s;
  s.trained.surfels.diffuse = test::sphere_layer(0.4, 20000);
  s.materials.resize(s.trained.surfels.diffuse.size());
  std::ranges::fill(s.materials.albedo, Vec3f{0.7f, 0.6f, 0.5f});
  std::ranges::fill(s.materials.roughness, 0.4f);
  std::ranges::fill(s.materials.f0, Vec3f{0.04f, 0.04f, 0.04f});
  std::ranges::fill(s.materials.specular_weight, 0.1f);
  s.captured = Environment(ImageF(16, 8, 3, 1.f));
  s.mesh = test::sphere_mesh(0.4, {}, rings, 2 * rings);
  return s;
}

void sample_environment(benchmark::State& state) {
  const Environment e = sunny();
  double mean = 0;
  Rng rng(1);
  for (int i = 0; i < 20000; ++i) {
    const auto s = e.sample({rng.uniform(), rng.uniform()});
    mean += s.radiance.x / s.pdf / 20000 / (4 * std::numbers::pi);
  }
  if (std::abs(mean / e.mean().x - 1) > 0.03) state.SkipWithError("the samples do not integrate to the mean radiance");
  for (auto _ : state) benchmark::DoNotOptimize(e.sample({rng.uniform(), rng.uniform()}));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(sample_environment)->Name("relight/environment_sample/1024x512");

// Origins on the ball, directions by the environment: about half are in its own shadow.
void shadow_rays(benchmark::State& state) {
  const RelitScene scene = ball(224);
  const SceneSurface surface(scene);
  const Environment e = sunny();
  Rng rng(2);
  if (surface.visibility({0.5f, 0, 0}, {-1, 0, 0}) != 0 || surface.visibility({0.5f, 0, 0}, {1, 0, 0}) != 1)
    state.SkipWithError("wrong visibility");
  std::vector<Vec3f> origins, directions;
  for (size_t i = 0; i < 4096; ++i) {
    const size_t v = rng.below(static_cast<uint32_t>(surface.mesh().positions.size()));
    origins.push_back(surface.mesh().positions[v] + surface.grain() * surface.mesh().normals[v]);
    directions.push_back(e.sample({rng.uniform(), rng.uniform()}).direction);
  }
  size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(surface.visibility(origins[i], directions[i]));
    i = (i + 1) % origins.size();
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(shadow_rays)->Name("relight/shadow_ray/100k_faces");

void light_on_mesh(benchmark::State& state) {
  const RelitScene scene = ball(112);
  const SceneSurface surface(scene);
  Lighting lighting;
  lighting.environment = sunny();
  for (auto _ : state) benchmark::DoNotOptimize(LitScene(surface, lighting).radiance().data());
  state.SetItemsProcessed(state.iterations() * int64_t(scene.mesh.positions.size()));
}
BENCHMARK(light_on_mesh)->Name("relight/light_on_mesh/25k_vertices")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

// Items are surfels: 576 rays into cells of the sky, of which half are below the horizon, and 64 for light from the scene.
void light_transfer(benchmark::State& state) {
  const RelitScene scene = ball(112);
  const SceneSurface surface(scene);
  const LightTransfer transfer(surface);
  const Environment white(ImageF(16, 8, 3, 1.f));
  const SplatLayer& surfels = scene.trained.surfels.diffuse;
  const float e = irradiance(transfer.of_surfels(surfels)[0], cell_light(white), light_harmonics(white)).x;
  if (std::abs(e / std::numbers::pi - 1) > 0.05) state.SkipWithError("a ball under white light does not receive pi");
  for (auto _ : state) benchmark::DoNotOptimize(transfer.of_surfels(surfels).data());
  state.SetItemsProcessed(state.iterations() * int64_t(surfels.size()));
}
BENCHMARK(light_transfer)->Name("relight/light_transfer/20k_surfels")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

// Items are samples: one ray to the light and one into the lobe.
void picture(benchmark::State& state) {
  RelitPainter painter(ball(224));
  Lighting white;
  white.environment = Environment(ImageF(16, 8, 3, 1.f));
  painter.set_lighting(white);
  View view;
  view.intrinsics = {160, 120, 240, 240, 80, 60};  // the ball fills the picture
  view.cam_from_world = test::looking_at({0.8, 0, 0.2}, {0, 0, 0});
  const float middle = painter.picture(view, {.samples = 64}).radiance.at(80, 60, 0);
  if (std::abs(middle - 0.7f) > 0.1f) state.SkipWithError("the ball under white light has not its own colour");
  Lighting lighting;
  lighting.environment = sunny();
  painter.set_lighting(lighting);
  for (auto _ : state) benchmark::DoNotOptimize(painter.picture(view, {.samples = 16}).radiance.data().data());
  state.SetItemsProcessed(state.iterations() * 160 * 120 * 16);
}
BENCHMARK(picture)->Name("relight/picture/160x120x16")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
}  // namespace vitrine
