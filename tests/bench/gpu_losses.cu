// The losses of training steps for a CUDA device: compiled so that device_usage_test.cpp bounds the registers of their kernels.
#include "core/learn/loss/blocks/loss_blocks.h"
#include "core/render/raster/blocks/cuda_launch.cuh"

template class vitrine::blocks::LossBlocks<vitrine::blocks::CudaLaunch>;
