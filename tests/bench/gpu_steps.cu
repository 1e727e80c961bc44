// Training steps on a CUDA device, for gpu_check.cpp; and compiled where there is no card, so that device_usage_test.cpp bounds
// the registers of their kernels.
#include "core/render/raster/blocks/cuda_launch.cuh"
#include "tests/bench/gpu_steps.h"
#include "tests/support/block_steps.h"

namespace vitrine {

GpuSteps gpu_steps(uint32_t surfels, int width, int height, int steps, std::map<std::string, double>* kernel_ms) {
  const test::StepScene scene(surfels, width, height, 2);
  const blocks::CudaLaunch executor, measured(kernel_ms);
  blocks::StepBlocks<blocks::CudaLaunch> device(kernel_ms == nullptr ? executor : measured, scene.start(),
                                                surfels + surfels / 20);
  const auto photos = test::add_photos(device, scene, executor);
  GpuSteps result;
  test::take_steps(device, photos, steps);
  device.relocate(1, static_cast<uint64_t>(steps), 0.02, 1.05);
  blocks::check_cuda(cudaDeviceSynchronize(), "a step failed");
  const auto begin = std::chrono::steady_clock::now();
  if (kernel_ms != nullptr) kernel_ms->clear();
  test::take_steps(device, photos, steps);
  blocks::check_cuda(cudaDeviceSynchronize(), "a step failed");
  result.ms = std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count() / steps;
  result.values = device.values();
  result.l1 = device.losses().l1;
  return result;
}

}  // namespace vitrine
