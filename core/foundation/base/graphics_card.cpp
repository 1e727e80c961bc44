#include "core/foundation/base/graphics_card.h"

#include <dlfcn.h>

#include <memory>

#include <fmt/format.h>

namespace vitrine {

namespace {

// The functions of the CUDA driver API (NVIDIA, "CUDA Driver API", version 13) that are needed here. 0 is success.
class Driver {
 public:
  explicit Driver(const char* library) : library_(dlopen(library, RTLD_NOW | RTLD_LOCAL)) {
    if (!library_) return;
    complete_ = load(init, "cuInit") && load(version, "cuDriverGetVersion") && load(count, "cuDeviceGetCount") &&
                load(get, "cuDeviceGet") && load(name, "cuDeviceGetName") && load(memory, "cuDeviceTotalMem_v2") &&
                load(attribute, "cuDeviceGetAttribute") && load(error_text, "cuGetErrorString");
  }
  bool found() const { return library_ != nullptr; }
  bool complete() const { return complete_; }
  std::string text_of(int error) const {
    const char* text = nullptr;
    return error_text(error, &text) == 0 && text != nullptr ? text : fmt::format("error {}", error);
  }

  int (*init)(unsigned) = nullptr;
  int (*version)(int*) = nullptr;
  int (*count)(int*) = nullptr;
  int (*get)(int*, int) = nullptr;
  int (*name)(char*, int, int) = nullptr;
  int (*memory)(size_t*, int) = nullptr;
  int (*attribute)(int*, int, int) = nullptr;
  int (*error_text)(int, const char**) = nullptr;

 private:
  template <class Function>
  bool load(Function& function, const char* symbol) {
    function = reinterpret_cast<Function>(dlsym(library_.get(), symbol));
    return function != nullptr;
  }
  struct Close {
    void operator()(void* library) const { dlclose(library); }
  };
  std::unique_ptr<void, Close> library_;
  bool complete_ = false;
};

}  // namespace

GraphicsCardSearch find_graphics_card(const char* driver_library) {
  constexpr int kMajor = 75, kMinor = 76;  // attributes: compute capability
  const Driver driver(driver_library);
  if (!driver.found()) return {{}, fmt::format("there is no NVIDIA driver ({} is not installed)", driver_library)};
  if (!driver.complete()) return {{}, fmt::format("{} is not the library of an NVIDIA driver", driver_library)};
  if (const int error = driver.init(0); error != 0)
    return {{}, fmt::format("the NVIDIA driver finds no usable card ({})", driver.text_of(error))};
  int devices = 0, device = 0, major = 0, minor = 0;
  if (driver.count(&devices) != 0 || devices == 0 || driver.get(&device, 0) != 0) return {{}, "the NVIDIA driver lists no card"};
  GraphicsCard card;
  std::array<char, 256> name{};
  if (driver.name(name.data(), int(name.size()) - 1, device) == 0) card.name = name.data();
  driver.memory(&card.memory_bytes, device);
  driver.version(&card.driver);
  if (driver.attribute(&major, kMajor, device) == 0 && driver.attribute(&minor, kMinor, device) == 0)
    card.capability = 10 * major + minor;
  return {card, {}};
}

}  // namespace vitrine
