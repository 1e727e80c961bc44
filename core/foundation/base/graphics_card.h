// The device that computes pictures, as a user chooses it, and the NVIDIA card of this machine. The library of the driver is
// loaded when the card is looked for: no program needs it to start.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace vitrine {

// Auto: CUDA where it is usable, else the CPU.
enum class Device { Cpu, Cuda, Auto };
inline constexpr std::array<std::string_view, 3> kDeviceWords{"cpu", "cuda", "auto"};

// Of a program that can compute on a device.
struct DeviceUse {
  // Before anything is computed. Returns the reason if Auto takes the CPU, else nothing. Throws Error{Device} if `device` is not
  // usable.
  std::string (*choose)(Device device) = nullptr;
  bool (*has_kernels)() = nullptr;  // of this build
};

struct GraphicsCard {
  std::string name;
  size_t memory_bytes = 0;
  // 10 major + minor: 80 is an A100, 90 an H100.
  int capability = 0;
  // Newest CUDA version that the driver knows: 1000 major + 10 minor.
  int driver = 0;
};
struct GraphicsCardSearch {
  std::optional<GraphicsCard> card;  // the one that CUDA takes first
  std::string why_not;               // there is none
};
// Throws nothing. `driver_library`: as dlopen() takes it.
GraphicsCardSearch find_graphics_card(const char* driver_library = "libcuda.so.1");

}  // namespace vitrine
