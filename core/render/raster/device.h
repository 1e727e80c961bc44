// The device on which the renderers and tracers of this process compute. make_renderer(Backend::Cpu) gives renderers of the CPU
// until use_device() chooses another one, before the first of them is made. Kernels for a device are linked into some programs
// (blocks/cuda_pass.cu); tests put the same kernels as loops in their place.
#pragma once

#include <memory>
#include <string>

#include "core/foundation/base/graphics_card.h"

namespace vitrine {

namespace blocks {
class BlockPass;
}

// Throws blocks::ExecutorFailure with the reason if the device is not usable.
using DevicePassMaker = std::unique_ptr<blocks::BlockPass> (*)();

// nullptr: this program has no kernels, as without a call. Returns the one before.
DevicePassMaker provide_device(DevicePassMaker maker);
bool has_device_kernels();

// DeviceUse::choose for the rasteriser. Errors: NO_KERNELS, NO_DEVICE.
std::string use_device(Device device);
// The kernels of the chosen device; nullptr: it is the CPU.
DevicePassMaker chosen_device();

inline constexpr DeviceUse kRasterDevice{use_device, has_device_kernels};

}  // namespace vitrine
