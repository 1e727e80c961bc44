// Training steps on a CUDA device (gpu_steps.cu).
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace vitrine {

struct GpuSteps {
  double ms = 0, l1 = 0;                   // of a step; of the last one
  std::vector<std::vector<float>> values;  // of the surfels after it, column by column
};

// Twice `steps` steps of tests/support/block_steps.h with a relocation between; the second half is measured. kernel_ms: times of
// kernels by name in that half, added up; each kernel is then waited for.
GpuSteps gpu_steps(uint32_t surfels, int width, int height, int steps, std::map<std::string, double>* kernel_ms = nullptr);

}  // namespace vitrine
