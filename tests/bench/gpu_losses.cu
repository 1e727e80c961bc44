// Losses and the random walk of training steps for a CUDA device: compiled so that device_usage_test.cpp bounds the registers of
// their kernels.
#include "core/learn/loss/blocks/loss_blocks.h"
#include "core/learn/optim/blocks/noise_kernel.h"
#include "core/render/raster/blocks/cuda_launch.cuh"

namespace vitrine::blocks {

template class LossBlocks<CudaLaunch>;
template void add_position_noise(CudaLaunch&, const SurfelArrays&, float*, float, uint64_t, uint64_t);

}  // namespace vitrine::blocks
