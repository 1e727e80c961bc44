// Training steps on a CUDA device. Only the target vitrine_cuda_steps has it.
#include "core/learn/trainer/blocks/step_blocks.h"
#include "core/render/raster/blocks/cuda_launch.cuh"

namespace vitrine {

std::unique_ptr<blocks::StepPass> blocks::make_cuda_steps(std::map<std::string, double>* kernel_ms) {
  return std::make_unique<StepBlocks<CudaLaunch>>(CudaLaunch(kernel_ms));
}

namespace {

// Programs that link this file have them; whether the device is usable is known before (cuda_pass.cu).
[[maybe_unused]] const StepPassMaker before = provide_step_device([] { return blocks::make_cuda_steps(); });

}  // namespace
}  // namespace vitrine
