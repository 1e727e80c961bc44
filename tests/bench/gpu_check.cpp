// The passes, forward and reverse, rays and whole training steps on a CUDA device against the same kernels run as loops on the
// CPU: bytes must be equal, also from run to run. Prints the time of each kernel, of steps and of rays. Exit codes: 0 equal, 1
// different, 7 no device.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "core/foundation/base/error.h"
#include "core/learn/trainer/blocks/step_blocks.h"
#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/renderer.h"
#include "tests/bench/gpu_rays.h"
#include "tests/support/block_steps.h"
#include "tests/support/tiny_scenes.h"

namespace vitrine {
namespace {

constexpr int kTimedRuns = 20;

std::vector<TinyScene> scenes(bool small) {
  std::vector<TinyScene> all = tiny_scenes();
  if (small) return all;
  all.push_back(cloud_scene("cloud_640x480", 20000, 640, 480, 0.05, 0.9, 21));
  all.push_back(cloud_scene("dense_320x240", 20000, 320, 240, 0.3, 0.3, 22));
  all.push_back(cloud_scene("large_1280x800", 100000, 1280, 800, 0.02, 0.9, 23));
  return all;
}

// Planes of the forward pass, gradients and statistics of the reverse pass, whose input are those planes.
std::vector<std::vector<float>> passes(Renderer& renderer, const TinyScene& scene) {
  RasterImages images;
  renderer.forward(scene.layer, scene.desc, images);
  SplatLayer grad = scene.layer.zeros_like();
  SurfelStatistics statistics;
  renderer.backward({.gradients = &images, .error_image = images.plane(Aov::Alpha)}, grad, &statistics);
  std::vector<std::vector<float>> all(images.planes.begin(), images.planes.end());
  for (const AttributeRow& r : kAttributes) all.emplace_back(grad.values(r.id).begin(), grad.values(r.id).end());
  for (const auto* v : {&statistics.screen_gradient, &statistics.weight, &statistics.error}) all.push_back(*v);
  return all;
}

// Number of floats whose bytes differ.
size_t differences(const std::vector<std::vector<float>>& a, const std::vector<std::vector<float>>& b) {
  size_t count = 0;
  for (size_t p = 0; p < a.size(); ++p) {
    if (a[p].size() != b[p].size()) return 1;
    for (size_t i = 0; i < a[p].size(); ++i) count += std::memcmp(&a[p][i], &b[p][i], sizeof(float)) != 0;
  }
  return count;
}

bool check(Renderer& device, TinyScene scene, FeatureSet features) {
  scene.desc.features = features;
  const auto expected = passes(*make_blocks_renderer(), scene), first = passes(device, scene), second = passes(device, scene);
  const size_t from_loops = differences(expected, first), from_first = differences(first, second);
  if (from_loops + from_first > 0)
    std::printf("DIFFERENT  %-16s %zu channels: %zu floats from the loops on the CPU, %zu from the first run\n",
                scene.name.c_str(), feature_count(features), from_loops, from_first);
  return from_loops + from_first == 0;
}

void print_times(const TinyScene& scene) {
  std::map<std::string, double> kernels;
  const auto device = make_blocks_renderer(make_cuda_pass(&kernels));
  passes(*device, scene);  // takes its memory
  kernels.clear();
  const auto begin = std::chrono::steady_clock::now();
  for (int i = 0; i < kTimedRuns; ++i) passes(*device, scene);
  const std::chrono::duration<double, std::milli> all = std::chrono::steady_clock::now() - begin;
  const RasterCounts counts = device->counts();
  std::printf("%s: %zu surfels, %llu instances, %llu fragments, %llu evaluated; both passes with copies %.3f ms\n",
              scene.name.c_str(), scene.layer.size(), static_cast<unsigned long long>(counts.instances),
              static_cast<unsigned long long>(counts.fragments), static_cast<unsigned long long>(counts.lanes),
              all.count() / kTimedRuns);
  double sum = 0;
  for (const auto& [kernel, ms] : kernels) {
    std::printf("  %8.3f ms  %s\n", ms / kTimedRuns, kernel.c_str());
    sum += ms / kTimedRuns;
  }
  std::printf("  %8.3f ms  all kernels\n", sum);
}

// Surfels after training steps that stay in the memory of the device, a relocation among them.
std::vector<std::vector<float>> trained(blocks::StepPass& steps, uint32_t surfels, int width, int height) {
  constexpr int kSteps = 10;
  test::StepScene scene(surfels, width, height, 2);
  const auto photos = scene.start(steps);
  test::take_steps(steps, scene, photos, kSteps);
  steps.relocate(1, kSteps, 0.02, 1.05, surfels + surfels / 20);
  steps.walk(10.f, 1, kSteps);
  test::take_steps(steps, scene, photos, kSteps);
  return test::surfel_values(steps);
}

bool check_steps() {
  blocks::StepBlocks<blocks::BlockLoops> loops{blocks::BlockLoops()};
  const size_t different = differences(trained(loops, 800, 90, 60), trained(*blocks::make_cuda_steps(), 800, 90, 60));
  std::printf("training steps: %zu floats differ from the loops on the CPU\n", different);
  return different == 0;
}

struct Timed {
  double ms, l1;  // of a step; of the last one
};
Timed timed_steps(uint32_t surfels, int width, int height, int count, std::map<std::string, double>* kernel_ms) {
  const auto steps = blocks::make_cuda_steps(kernel_ms);
  test::StepScene scene(surfels, width, height, 2);
  const auto photos = scene.start(*steps);
  test::take_steps(*steps, scene, photos, count);
  steps->report();
  if (kernel_ms != nullptr) kernel_ms->clear();
  const auto begin = std::chrono::steady_clock::now();
  test::take_steps(*steps, scene, photos, count);
  const double l1 = steps->report()->l1;  // waits
  const std::chrono::duration<double, std::milli> all = std::chrono::steady_clock::now() - begin;
  return {all.count() / count, l1};
}

void print_steps(uint32_t surfels, int width, int height) {
  constexpr int kSteps = 50;
  std::map<std::string, double> kernels;
  const Timed steps = timed_steps(surfels, width, height, kSteps, nullptr);
  timed_steps(surfels, width, height, kSteps, &kernels);
  std::printf("step, %d x %d, %u surfels: %.3f ms (L1 %.4f)\n", width, height, surfels, steps.ms, steps.l1);
  for (const auto& [kernel, ms] : kernels) std::printf("  %8.3f ms  %s\n", ms / kSteps, kernel.c_str());
}

int run(bool small) {
  const auto device = make_blocks_renderer(make_cuda_pass());
  bool equal = true;
  for (const TinyScene& scene : scenes(small))
    for (const FeatureSet features : {FeatureSet::ColorOnly, FeatureSet::Surface, FeatureSet::Material})
      equal = check(*device, scene, features) && equal;
  equal = check_steps() && equal;
  equal = check_rays(small) && equal;
  std::printf("%s\n", equal ? "equal: device, loops on the CPU, and the second run on the device" : "the bytes differ");
  for (const TinyScene& scene : scenes(small))
    if (scene.layer.size() > 1000) print_times(scene);
  if (!small) {
    print_steps(50000, 480, 270);
    print_steps(300000, 1280, 800);
    print_ray_times();
  }
  return equal ? 0 : 1;
}

}  // namespace
}  // namespace vitrine

int main(int argc, char** argv) {
  try {
    return vitrine::run(argc > 1 && std::string(argv[1]) == "small");
  } catch (const std::exception& e) {
    std::fprintf(stderr, "error: %s\n", e.what());
    return 7;
  }
}
