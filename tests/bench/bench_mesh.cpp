// Fusion and surface extraction on a sphere seen by 12 cameras: voxel updates, cells and closest-point queries per second.
// The result is checked against the sphere before anything is timed. Names: mesh/<what>.
#include <benchmark/benchmark.h>

#include <cmath>

#include "core/foundation/base/rng.h"
#include "core/scene/mesh/mesh_distance.h"
#include "core/scene/mesh/tri_mesh.h"
#include "core/scene/mesh/tsdf_volume.h"
#include "tests/core/scene/mesh/orbit.h"

namespace vitrine {
namespace {

constexpr double kRadius = 0.4, kVoxel = 1.2 / 192;

struct SphereScene {
  std::vector<orbit::Map> maps;
  TsdfVolume volume{{.bounds = {{-0.6, -0.6, -0.6}, {0.6, 0.6, 0.6}}, .voxel = kVoxel}};
  TriMesh mesh;
  bool correct = false;

  SphereScene() {
    for (const View& v : orbit::views(6, {-35, 35}, 1.5, 480))
      maps.push_back(orbit::map(v, [](const Vec3d& o, const Vec3d& d) { return orbit::hit_sphere({0, 0, 0}, kRadius, o, d); }));
    for (const auto& m : maps) volume.touch(m.view());
    volume.allocate();
    for (const auto& m : maps) volume.integrate(m.view());
    mesh = iso_surface(volume);
    double error = 0;
    for (const Vec3f& p : mesh.positions) error += std::abs(double(length(p)) - kRadius) / double(mesh.positions.size());
    correct = mesh_report(mesh).closed() && error < 0.25 * kVoxel;
  }
};

SphereScene* scene_or_skip(benchmark::State& state) {
  static SphereScene scene;
  if (scene.correct) return &scene;
  state.SkipWithError("the fused sphere is wrong");
  return nullptr;
}

void tsdf(benchmark::State& state) {
  SphereScene* scene = scene_or_skip(state);
  if (!scene) return;
  size_t updates = 0, view = 0;
  for (auto _ : state) updates += scene->volume.integrate(scene->maps[view++ % scene->maps.size()].view());
  state.counters["voxel_updates"] = benchmark::Counter(double(updates), benchmark::Counter::kIsRate);
}
BENCHMARK(tsdf)->Name("mesh/tsdf")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

void marching_cubes(benchmark::State& state) {
  SphereScene* scene = scene_or_skip(state);
  if (!scene) return;
  for (auto _ : state) benchmark::DoNotOptimize(iso_surface(scene->volume).faces.size());
  const double cells = double(scene->volume.block_count()) * TsdfBlock::kVoxels;
  state.counters["cells"] = benchmark::Counter(cells, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(marching_cubes)->Name("mesh/marching_cubes")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

void closest_point(benchmark::State& state) {
  SphereScene* scene = scene_or_skip(state);
  if (!scene) return;
  const MeshDistance distance(scene->mesh);
  const SurfaceSamples samples = sample_surface(scene->mesh, 200000, 1);
  for (auto _ : state) benchmark::DoNotOptimize(distance.distances(samples.positions).data());
  state.counters["queries"] = benchmark::Counter(double(samples.positions.size()), benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(closest_point)->Name("mesh/closest_point")->Unit(benchmark::kMillisecond)->MeasureProcessCPUTime();

}  // namespace
}  // namespace vitrine
