#include "core/render/raster/device.h"

#include <optional>
#include <utility>

#include "core/foundation/base/error.h"
#include "core/render/raster/blocks/block_pass.h"

namespace vitrine {

namespace {

// Constant when the program starts: kernels that are linked in provide themselves before main().
constinit DevicePassMaker provided = nullptr;
constinit DevicePassMaker chosen = nullptr;

struct Unusable {
  std::string message, why, hint, code;
};

std::optional<Unusable> why_unusable() {
  if (provided == nullptr)
    return Unusable{"this program has no kernels for a GPU", "it was built on a machine without nvcc, the CUDA compiler",
                    "--device cpu; or install CUDA 12.4 or newer, run cmake again and build", "NO_KERNELS"};
  try {
    provided();
    return std::nullopt;
  } catch (const blocks::ExecutorFailure& e) {
    return Unusable{"no GPU is usable here", e.what(), "--device cpu, or --device auto; `vitrine doctor` describes the card",
                    "NO_DEVICE"};
  }
}

}  // namespace

DevicePassMaker provide_device(DevicePassMaker maker) { return std::exchange(provided, maker); }
bool has_device_kernels() { return provided != nullptr; }
DevicePassMaker chosen_device() { return chosen; }

std::string use_device(Device device) {
  chosen = nullptr;
  if (device == Device::Cpu) return {};
  if (const auto unusable = why_unusable()) {
    if (device == Device::Auto) return fmt::format("{}: {}", unusable->message, unusable->why);
    throw Error(ErrorKind::Device, unusable->message,
                {.where = "--device cuda", .why = unusable->why, .hint = unusable->hint, .code = unusable->code});
  }
  chosen = provided;
  return {};
}

}  // namespace vitrine
