#include "tests/bench/gpu_rays.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>

#include "core/render/trace/blocks/trace_pass.h"
#include "tests/core/render/trace/ray_scenes.h"

namespace vitrine {
namespace {

// Number of floats of a forward and a reverse pass whose bytes differ.
size_t differences(const RayScene& scene, const TracePass& a, const TracePass& b) {
  size_t count = 0;
  const auto compare = [&](std::span<const float> x, std::span<const float> y) {
    if (x.size() != y.size()) ++count;
    for (size_t i = 0; i < std::min(x.size(), y.size()); ++i) count += std::memcmp(&x[i], &y[i], sizeof(float)) != 0;
  };
  compare(flat(a.values.color), flat(b.values.color));
  compare(a.values.transmittance, b.values.transmittance);
  compare(a.values.distance, b.values.distance);
  compare(a.values.first_hit, b.values.first_hit);
  compare(flat(a.values.normal), flat(b.values.normal));
  for (const AttributeRow& r : kAttributes) compare(a.grad.values(r.id), b.grad.values(r.id));
  compare(a.statistics.screen_gradient, b.statistics.screen_gradient);
  compare(a.statistics.weight, b.statistics.weight);
  compare(a.statistics.error, b.statistics.error);
  compare(flat(a.rays.origins), flat(b.rays.origins));
  compare(flat(a.rays.directions), flat(b.rays.directions));
  for (size_t i = 0; i < scene.origins.size(); ++i) {
    const auto x = a.hits.of(i), y = b.hits.of(i);
    if (x.size() != y.size()) ++count;
    for (size_t h = 0; h < std::min(x.size(), y.size()); ++h)
      count += x[h].surfel != y[h].surfel || x[h].t != y[h].t || x[h].alpha != y[h].alpha || x[h].color != y[h].color;
  }
  return count;
}

// Of a size that a ray blends about thirty, in [-1,1]^3; rays of any origin and direction.
RayScene volume(size_t surfels, size_t rays) {
  return ray_cloud("volume", surfels, rays, 0.018 * std::sqrt(1e5 / double(surfels)), 0.4, 61);
}

double seconds_of(const auto& run) {
  const auto begin = std::chrono::steady_clock::now();
  run();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

}  // namespace

bool check_rays(bool small) {
  const auto device = make_blocks_tracer(make_cuda_trace());
  std::vector<RayScene> scenes = ray_scenes();
  if (!small) scenes.push_back(volume(20000, 50000));
  bool equal = true;
  for (const RayScene& scene : scenes) {
    const TracePass expected = run(*make_blocks_tracer(), scene), first = run(*device, scene), second = run(*device, scene);
    const size_t from_loops = differences(scene, expected, first), from_first = differences(scene, first, second);
    equal = equal && from_loops + from_first == 0;
    if (from_loops + from_first > 0)
      std::printf("DIFFERENT  rays, %-16s %zu values from the loops on the CPU, %zu from the first run\n", scene.name.c_str(),
                  from_loops, from_first);
  }
  std::printf("%zu scenes of rays: %s\n", scenes.size(), equal ? "equal" : "different");
  return equal;
}

void print_ray_times() {
  const RayScene scene = volume(300000, 1000000);
  std::map<std::string, double> kernels;
  const auto device = make_blocks_tracer(make_cuda_trace()), measured = make_blocks_tracer(make_cuda_trace(&kernels));
  TracePass pass;
  const double build = seconds_of([&] { device->build(scene.layer); });
  const auto forward = [&](HitLists* hits) { device->forward(scene.rays(), scene.desc, pass.values, hits); };
  forward(&pass.hits);  // takes its memory
  const double values = seconds_of([&] { forward(nullptr); }), lists = seconds_of([&] { forward(&pass.hits); });
  const RayValues gradients = random_gradients(scene.origins.size(), 3);
  pass.grad = scene.layer.zeros_like();
  const double reverse = seconds_of([&] {
    device->backward(scene.rays(), scene.desc, pass.hits, {.gradients = &gradients}, pass.grad, &pass.rays, &pass.statistics);
  });
  const double n = double(scene.origins.size());
  std::printf(
      "%.0f rays, %zu surfels, %.1f hits a ray, with copies: build %.3f s, forward %.3f s, with lists %.3f s, reverse %.3f s\n",
      n, scene.layer.size(), double(pass.hits.size()) / n, build, values, lists, reverse);
  run(*measured, scene);
  double ms = 0;
  for (const auto& [kernel, of_kernel] : kernels) {
    std::printf("  %8.3f ms  %s\n", of_kernel, kernel.c_str());
    if (kernel.find("TraceKernel") != kernel.npos) ms += of_kernel;
  }
  // Values, then lists: every ray is traced twice.
  if (ms > 0) std::printf("%.1f million rays in a second, without copies\n", 2e-6 * n / (ms * 1e-3));
}

}  // namespace vitrine
