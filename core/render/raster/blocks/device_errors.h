// Failures of a device as errors that name the work and what may fit instead. For renderers and tracers over the kernels.
#pragma once

#include <algorithm>
#include <functional>
#include <string>

#include "core/foundation/base/error.h"
#include "core/foundation/base/terminal.h"
#include "core/render/raster/blocks/block_kernel.h"

namespace vitrine::blocks {

struct DeviceWork {
  std::string name;                            // "the picture"
  std::string size;                            // "300 surfels, 200 x 150 pixels"
  std::function<std::string(double)> smaller;  // what this share of the work is, for a hint
};

// Returns run(). Errors: DEVICE_MEMORY, DEVICE_OVERFLOW (exit 6), CUDA_FAILED (exit 8).
template <class Run, class Describe>
auto on_device(const Run& run, const Describe& describe) {
  try {
    return run();
  } catch (const ExecutorMemory& e) {
    // The greater part of the memory grows with the work; a reverse pass takes as much again.
    const double share = 0.5 * static_cast<double>(e.held + e.free) / static_cast<double>(e.held + e.needed);
    const DeviceWork work = describe();
    throw Error(ErrorKind::Resource, "the device has too little memory",
                {.where = work.size,
                 .why = fmt::format("{} more are needed, {} are free, {} are in use", bytes_text(e.needed), bytes_text(e.free),
                                    bytes_text(e.held)),
                 .hint = work.smaller(std::min(share, 0.9)),
                 .code = "DEVICE_MEMORY"});
  } catch (const ExecutorOverflow& e) {
    const DeviceWork work = describe();
    throw Error(ErrorKind::Resource, fmt::format("{} is too large for the device", work.name),
                {.where = work.size,
                 .why = fmt::format("there are more than {} {}", kMostItems, e.what()),
                 .hint = work.smaller(0.5),
                 .code = "DEVICE_OVERFLOW"});
  } catch (const ExecutorFailure& e) {
    throw Error(ErrorKind::Device, "the device failed", {.why = e.what(), .hint = "--device cpu", .code = "CUDA_FAILED"});
  }
}

}  // namespace vitrine::blocks
