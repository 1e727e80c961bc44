// The passes on a CUDA device. Only the target vitrine_cuda has it.
#include <map>
#include <string>

#include "core/render/raster/blocks/cuda_launch.cuh"

namespace vitrine {

std::unique_ptr<blocks::BlockPass> make_cuda_pass(std::map<std::string, double>* kernel_ms) {
  int devices = 0;
  blocks::check_cuda(cudaGetDeviceCount(&devices), "no device");
  if (devices == 0) throw blocks::ExecutorFailure("CUDA: no device");
  return std::make_unique<blocks::ExecutorPass<blocks::CudaLaunch>>(blocks::CudaLaunch(kernel_ms));
}

}  // namespace vitrine
