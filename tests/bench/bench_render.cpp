// Raster passes: milliseconds, fragments per second and core, and what the machine could do at most.
// A fragment is one pixel of one surfel inside its ellipse (alpha >= 1/255); a lane is one pixel of one evaluated vector, in or
// out of the ellipse. Before a row is timed, the same renderer must agree
// with the reference on a small scene. Names: raster/<direction>/<surfels>/<width>x<height>/<features>/threads:<n>[/simd].
#include <benchmark/benchmark.h>
#include <immintrin.h>

#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "core/foundation/base/parallel.h"
#include "core/foundation/base/rng.h"
#include "core/foundation/base/timer.h"
#include "core/render/raster/renderer.h"
#include "tests/support/gradcheck.h"
#include "tests/support/tiny_scenes.h"

namespace vitrine {
namespace {

// Two shells of surfels, an object and what is behind it, that lie on their surfaces as after training: spacing-sized, jittered
// normals and depths, mixed opacities.
struct BenchScene {
  SplatLayer layer{LayerKind::Diffuse, 1, 0};
  RasterDesc desc;
};

BenchScene two_shells(size_t count, int width, int height, FeatureSet features) {
  BenchScene s;
  s.desc.intrinsics = {width, height, 0.9 * width, 0.9 * width, 0.5 * width, 0.5 * height};
  s.desc.cam_from_world.translation = {0, 0, 3.2};
  s.desc.features = features;
  s.desc.sh_degree = 1;
  s.layer.resize(count);
  Rng rng(1);
  for (size_t i = 0; i < count; ++i) {
    const double radius = rng.uniform() < 0.5f ? 1.0 : 2.2, spacing = radius * std::sqrt(4 * 3.14159265 / (0.5 * double(count)));
    const Vec3d out = normalized(Vec3d{rng.normal(), rng.normal(), rng.normal()});
    const Vec3d n = normalized(out + 0.15 * Vec3d{rng.normal(), rng.normal(), rng.normal()});
    const Vec3d mean = (radius + 0.2 * spacing * rng.normal()) * out;
    const Vec3d t = normalized(cross(n, std::abs(n.x) < 0.7 ? Vec3d{1, 0, 0} : Vec3d{0, 1, 0}));
    const Quatd q = quaternion(Mat3d{t, cross(n, t), n});
    for (size_t c = 0; c < 3; ++c) s.layer.at(Attribute::Mean, i)[c] = static_cast<float>(mean[c]);
    const double quat[] = {q.w, q.x, q.y, q.z};
    for (size_t c = 0; c < 4; ++c) s.layer.at(Attribute::Rotation, i)[c] = static_cast<float>(quat[c]);
    for (size_t c = 0; c < 2; ++c)
      s.layer.at(Attribute::LogScale, i)[c] = static_cast<float>(std::log(spacing * (0.25 + 0.5 * rng.uniform_double())));
    s.layer.at(Attribute::Opacity, i)[0] = logit(0.1f + 0.85f * rng.uniform());
    for (Attribute a : {Attribute::ShDc, Attribute::ShRest, Attribute::F0, Attribute::Roughness, Attribute::SpecularWeight,
                        Attribute::Transmission})
      for (size_t c = 0; c < s.layer.width(a); ++c) s.layer.at(a, i)[c] = 0.3f * rng.normal();
  }
  return s;
}

// Gradients of everything that a training step uses.
RasterImages upstream(const RasterDesc& desc) {
  RasterImages g;
  g.reset(desc);
  Rng rng(2);
  for (Aov a :
       {Aov::Color, Aov::Normal, Aov::F0, Aov::Roughness, Aov::SpecularWeight, Aov::Transmission, Aov::ZDepth, Aov::Alpha})
    for (float& v : g.plane(a)) v = 1e-3f * rng.normal();
  g.planes[static_cast<size_t>(Aov::MedianZ)].clear();
  return g;
}

// Empty when the renderer agrees with the reference on a small scene of the same kind.
std::string disagreement(Simd simd, FeatureSet features) {
  const BenchScene s = two_shells(400, 50, 40, features);
  const auto cpu = make_renderer(Backend::Cpu, simd), reference = make_renderer(Backend::Reference);
  const RasterImages g = upstream(s.desc);
  RasterImages a, e;
  SplatLayer grad_a = s.layer.zeros_like(), grad_e = s.layer.zeros_like();
  cpu->forward(s.layer, s.desc, a);
  cpu->backward({.gradients = &g}, grad_a, nullptr);
  reference->forward(s.layer, s.desc, e);
  reference->backward({.gradients = &g}, grad_e, nullptr);
  for (const AovRow& r : kAovs)
    for (size_t i = 0; i < e.plane(r.id).size(); ++i)
      if (!(std::abs(a.plane(r.id)[i] - e.plane(r.id)[i]) < 1e-4f)) return std::string(r.name) + " differs from the reference";
  for (Attribute attribute : {Attribute::Mean, Attribute::Rotation, Attribute::LogScale, Attribute::Opacity, Attribute::ShDc}) {
    const GradTolerance t{.relative_l2 = 1e-3, .bias = 1e-3};
    const std::string problem = compare_gradients<float, float>(grad_a.values(attribute), grad_e.values(attribute), t).problem(t);
    if (!problem.empty()) return "gradient of " + std::string(row(attribute).name) + ": " + problem;
  }
  return "";
}

void raster(benchmark::State& state, size_t count, int width, int height, FeatureSet features, int threads, Simd simd,
            bool backward) {
  if (!machine_has(simd)) return state.SkipWithError("this machine lacks the instruction set");
  set_thread_limit(threads);
  const std::string problem = disagreement(simd, features);
  if (!problem.empty()) return state.SkipWithError(problem.c_str());
  const BenchScene s = two_shells(count, width, height, features);
  const auto renderer = make_renderer(Backend::Cpu, simd);
  const RasterImages g = upstream(s.desc);
  SplatLayer grad = s.layer.zeros_like();
  SurfelStatistics statistics;
  RasterImages out;
  renderer->forward(s.layer, s.desc, out);
  renderer->backward({.gradients = &g}, grad, &statistics);
  for (auto _ : state) {
    if (backward)
      renderer->backward({.gradients = &g}, grad, &statistics);
    else
      renderer->forward(s.layer, s.desc, out);
  }
  const RasterCounts counts = renderer->counts();
  set_thread_limit(0);
  state.counters["fragments"] = double(counts.fragments);
  state.counters["lane_use"] = double(counts.fragments) / double(counts.lanes);
  // Rates divide by the CPU time of the whole process: per core, whatever else runs on the machine.
  const auto per_second = [&](uint64_t n) {
    return benchmark::Counter(double(n) * double(state.iterations()), benchmark::Counter::kIsRate);
  };
  state.counters["frag/s/core"] = per_second(counts.fragments);
  state.counters["lanes/s/core"] = per_second(counts.lanes);
}

// Fused multiply-adds per second of one core: the limit of any such loop. Twelve chains hide the latency.
__attribute__((noinline, target("avx512f"))) float fma_avx512(int n) {
  __m512 a[12];
  for (auto& x : a) x = _mm512_set1_ps(1.f);
  benchmark::DoNotOptimize(n);
  const __m512 b = _mm512_set1_ps(0.999f), c = _mm512_set1_ps(1e-3f);
  for (int i = 0; i < n; ++i)
    for (auto& x : a) x = _mm512_fmadd_ps(x, b, c);
  float lanes[16], sum = 0;
  for (auto& x : a) {
    _mm512_storeu_ps(lanes, x);
    for (float v : lanes) sum += v;
  }
  return sum;
}
__attribute__((noinline)) float fma_avx2(int n) {
  __m256 a[12];
  for (auto& x : a) x = _mm256_set1_ps(1.f);
  benchmark::DoNotOptimize(n);
  const __m256 b = _mm256_set1_ps(0.999f), c = _mm256_set1_ps(1e-3f);
  for (int i = 0; i < n; ++i)
    for (auto& x : a) x = _mm256_fmadd_ps(x, b, c);
  float lanes[8], sum = 0;
  for (auto& x : a) {
    _mm256_storeu_ps(lanes, x);
    for (float v : lanes) sum += v;
  }
  return sum;
}
void peak_fma(benchmark::State& state, Simd simd) {
  if (!machine_has(simd)) return state.SkipWithError("this machine lacks the instruction set");
  const int steps = 100000;
  const int lanes = simd == Simd::Avx512 ? 16 : 8;
  for (auto _ : state) {
    const float sum = simd == Simd::Avx512 ? fma_avx512(steps) : fma_avx2(steps);
    benchmark::DoNotOptimize(sum);
    benchmark::ClobberMemory();
  }
  state.counters["flop/s/core"] =
      benchmark::Counter(2.0 * 12 * steps * lanes * double(state.iterations()), benchmark::Counter::kIsRate);
}

const bool registered = [] {
  struct Size {
    size_t count;
    int width, height;
  };
  const auto add = [](Size s, FeatureSet features, int threads, Simd simd, bool backward) {
    const std::string name = std::string("raster/") + (backward ? "backward/" : "forward/") + std::to_string(s.count / 1000) +
                             "k/" + std::to_string(s.width) + "x" + std::to_string(s.height) + "/" +
                             std::to_string(feature_count(features)) + "f/threads:" + std::to_string(threads) +
                             (simd == Simd::Avx512 ? "/avx512"
                              : simd == Simd::Avx2 ? "/avx2"
                                                   : "");
    benchmark::RegisterBenchmark(name.c_str(), raster, s.count, s.width, s.height, features, threads, simd, backward)
        ->Unit(benchmark::kMillisecond)
        ->MeasureProcessCPUTime();
  };
  constexpr Size kSizes[] = {{13000, 270, 480}, {50000, 270, 480}, {100000, 1008, 752}};
  for (bool backward : {false, true}) {
    for (const Size& s : kSizes)
      for (FeatureSet f : {FeatureSet::Material, FeatureSet::Surface})
        for (int threads : {1, 2}) add(s, f, threads, Simd::Best, backward);
    for (Simd simd : {Simd::Avx2, Simd::Avx512}) add(kSizes[1], FeatureSet::Material, 1, simd, backward);
  }
  benchmark::RegisterBenchmark("machine/peak_fma/avx2", peak_fma, Simd::Avx2);
  benchmark::RegisterBenchmark("machine/peak_fma/avx512", peak_fma, Simd::Avx512);
  return true;
}();

}  // namespace
}  // namespace vitrine
