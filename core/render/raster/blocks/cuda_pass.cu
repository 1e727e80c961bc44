// The passes on a CUDA device. Only the target vitrine_cuda has it.
#include <map>
#include <string>

#include "core/render/raster/blocks/cuda_launch.cuh"
#include "core/render/raster/device.h"

namespace vitrine {

std::unique_ptr<blocks::BlockPass> make_cuda_pass(std::map<std::string, double>* kernel_ms) {
  const GraphicsCardSearch found = find_graphics_card();
  if (!found.card) throw blocks::ExecutorFailure(found.why_not);
  int devices = 0;
  blocks::check_cuda(cudaGetDeviceCount(&devices), "no device");
  cudaFuncAttributes attributes;  // fails where no kernel was compiled for the card
  blocks::check_cuda(cudaFuncGetAttributes(&attributes, blocks::run_kernel<blocks::OwnerKernel>), "no kernels for this card");
  return std::make_unique<blocks::ExecutorPass<blocks::CudaLaunch>>(blocks::CudaLaunch(kernel_ms));
}

namespace {

// Programs that link this file have kernels.
[[maybe_unused]] const DevicePassMaker before = provide_device([] { return make_cuda_pass(); });

}  // namespace
}  // namespace vitrine
