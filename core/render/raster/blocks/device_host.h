// Pictures on the side of the host of a device: their view as kernels take it, and what they are in messages of errors.
#pragma once

#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/blocks/device_errors.h"
#include "core/render/raster/raster_desc.h"

namespace vitrine::blocks {

// `layer_degree`: of the harmonics that the surfels have.
BlockView block_view(const RasterDesc& desc, int layer_degree);

// A picture that a device renders, for messages.
struct DeviceLoad {
  size_t surfels;
  int width, height;
  DeviceWork work() const;
};
template <class Run>
auto on_device(const DeviceLoad& load, const Run& run) {
  return on_device(run, [&] { return load.work(); });
}

}  // namespace vitrine::blocks
