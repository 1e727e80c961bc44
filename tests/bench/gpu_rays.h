// Rays on a CUDA device, for gpu_check.cpp.
#pragma once

namespace vitrine {

// Values, hits and gradients of the device against those of the loops on the CPU and of a second run; prints what differs.
bool check_rays(bool small);

// One million rays against 300,000 surfels: rays in a second, and the time of each kernel.
void print_ray_times();

}  // namespace vitrine
