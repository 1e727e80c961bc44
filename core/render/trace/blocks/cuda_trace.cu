// The tracer on a CUDA device. Only the target vitrine_cuda has it.
#include "core/render/raster/blocks/cuda_launch.cuh"
#include "core/render/trace/blocks/trace_pass.h"

namespace vitrine {

std::unique_ptr<blocks::TracePass> make_cuda_trace(std::map<std::string, double>* kernel_ms) {
  cudaFuncAttributes attributes;  // fails where there is no device, and where no kernel was compiled for it
  blocks::check_cuda(cudaFuncGetAttributes(&attributes, blocks::run_kernel<blocks::TraceKernel<3>>), "no kernels for this card");
  return std::make_unique<blocks::ExecutorTrace<blocks::CudaLaunch>>(blocks::CudaLaunch(kernel_ms));
}

namespace {

// Programs that link this file have kernels.
[[maybe_unused]] const DeviceTraceMaker before = provide_device_tracer([] { return make_cuda_trace(); });

}  // namespace
}  // namespace vitrine
