// Volumes of 3D Gaussians: line integrals, emission and absorption, forward and backward; rates compare with those of trace/
// (hits a ray and rays a second and core) and raster/ (an instance is a Gaussian in a tile of 64 rays). Before a row is timed,
// the fast path must agree with the reference on a few rays.
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/render/volume/emission_absorption.h"
#include "core/render/volume/reference/reference.h"

namespace vitrine {
namespace {

struct VolumeBench {
  static constexpr int kSide = 192;
  std::vector<Gaussian3f> gaussians;
  std::vector<Vec3f> colors;
  std::vector<VolumeRay> rays;
};

// Gaussians of any orientation anywhere in [-1,1]^3, of a size that a ray meets about as many as in the coherent rows of trace/;
// rays fan out of a point before them.
VolumeBench cloud_of(size_t count) {
  VolumeBench b;
  Rng rng(1);
  const double size = 0.0085 * std::sqrt(1e5 / double(count));
  for (size_t i = 0; i < count; ++i) {
    Gaussian3f g;
    for (size_t c = 0; c < 3; ++c) {
      g.mean[c] = 2 * rng.uniform() - 1;
      g.log_scale[c] = static_cast<float>(std::log(size * (0.5 + rng.uniform_double())));
    }
    g.rotation = {rng.normal(), rng.normal(), rng.normal(), rng.normal()};
    g.log_density = static_cast<float>(std::log((0.02 + 0.2 * rng.uniform_double()) / size));
    b.gaussians.push_back(g);
    b.colors.push_back({rng.uniform(), rng.uniform(), rng.uniform()});
  }
  for (int y = 0; y < VolumeBench::kSide; ++y)
    for (int x = 0; x < VolumeBench::kSide; ++x)
      b.rays.push_back(
          {{0, 0, -3}, normalized(Vec3d{(x + 0.5) / VolumeBench::kSide - 0.5, (y + 0.5) / VolumeBench::kSide - 0.5, 1.8})});
  return b;
}

// Empty when line integrals and light of a few rays are those of the reference.
std::string disagreement(const VolumeBench& b, const RayTiles& tiles) {
  std::vector<Gaussian3d> exact;
  std::vector<Vec3d> colors;
  for (const Gaussian3f& g : b.gaussians) exact.push_back(cast<double>(g));
  for (const Vec3f& c : b.colors) colors.push_back(cast<double>(c));
  std::vector<VolumeRay> few;
  std::vector<size_t> pixels;
  for (size_t i = 1; i < 5; ++i) {
    pixels.push_back(i * b.rays.size() / 5 + VolumeBench::kSide / 3);
    few.push_back(b.rays[pixels.back()]);
  }
  std::vector<float> integrals(b.rays.size());
  std::vector<VolumeLightf> light(b.rays.size());
  LineIntegrals(tiles, b.gaussians).forward(integrals);
  EmissionAbsorption(tiles, b.gaussians).forward(b.colors, light);
  const std::vector<double> lines = reference_line_integrals(exact, few);
  const std::vector<VolumeLightd> truth = reference_emission({exact, colors}, few);
  for (size_t i = 0; i < few.size(); ++i) {
    if (!(std::abs(double(integrals[pixels[i]]) - lines[i]) < 5e-3 * lines[i]))
      return "a line integral differs from the reference";
    if (!(length(cast<double>(light[pixels[i]].color) - truth[i].color) < 2e-2))
      return "the light of a ray differs from the reference";
  }
  return "";
}

enum class VolumeWork { Lines, LinesBackward, Emission, EmissionBackward, Tiles };

void volume_row(benchmark::State& state, size_t count, VolumeWork work, int threads) {
  const VolumeBench b = cloud_of(count);
  const RayTiles tiles(b.rays, VolumeBench::kSide, {});
  if (const std::string problem = disagreement(b, tiles); !problem.empty()) return state.SkipWithError(problem.c_str());
  set_thread_limit(threads);
  const EmissionAbsorption emission(tiles, b.gaussians);
  const LineIntegrals lines(tiles, b.gaussians);
  std::vector<float> values(b.rays.size()), gradient(b.rays.size());
  std::vector<VolumeLightf> light(b.rays.size()), of_light(b.rays.size());
  Rng rng(2);
  for (size_t i = 0; i < b.rays.size(); ++i) {
    gradient[i] = rng.normal();
    of_light[i] = {{rng.normal(), rng.normal(), rng.normal()}, rng.normal()};
  }
  std::vector<Gaussian3Gradient> out(count);
  std::vector<Vec3f> out_colors(count);
  for (auto _ : state) {
    if (work == VolumeWork::Lines) lines.forward(values);
    if (work == VolumeWork::LinesBackward) lines.backward(gradient, out);
    if (work == VolumeWork::Emission) emission.forward(b.colors, light);
    if (work == VolumeWork::EmissionBackward) emission.backward(b.colors, of_light, out, out_colors);
    if (work == VolumeWork::Tiles) benchmark::DoNotOptimize(EmissionAbsorption(tiles, b.gaussians).instances());
  }
  set_thread_limit(0);
  state.counters["pairs/ray"] = double(lines.instances()) * double(RayTiles::kRays) / double(b.rays.size());
  state.counters["rays/s/core"] =
      benchmark::Counter(double(b.rays.size()) * double(state.iterations()), benchmark::Counter::kIsRate);
}

const bool volume_registered = [] {
  const std::pair<const char*, VolumeWork> works[] = {{"lines/forward", VolumeWork::Lines},
                                                      {"lines/backward", VolumeWork::LinesBackward},
                                                      {"emission/forward", VolumeWork::Emission},
                                                      {"emission/backward", VolumeWork::EmissionBackward},
                                                      {"emission/tiles", VolumeWork::Tiles}};
  for (const size_t count : {15000, 100000})
    for (const int threads : {1, 2})
      for (const auto& [name, work] : works) {
        const std::string row =
            "volume/" + std::string(name) + "/" + std::to_string(count / 1000) + "k/threads:" + std::to_string(threads);
        benchmark::RegisterBenchmark(row.c_str(), volume_row, count, work, threads)
            ->Unit(benchmark::kMillisecond)
            ->MeasureProcessCPUTime();
      }
  return true;
}();

}  // namespace
}  // namespace vitrine
