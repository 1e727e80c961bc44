// The functions of a CUDA driver with one card, for device_test.cpp: what find_graphics_card() calls, with its argument types.
#include <cstddef>
#include <cstring>

#define EXPORTED extern "C" __attribute__((visibility("default")))

EXPORTED int cuInit(unsigned) { return 0; }
EXPORTED int cuDriverGetVersion(int* version) {
  *version = 12040;
  return 0;
}
EXPORTED int cuDeviceGetCount(int* count) {
  *count = 1;
  return 0;
}
EXPORTED int cuDeviceGet(int* device, int) {
  *device = 5;
  return 0;
}
EXPORTED int cuDeviceGetName(char* name, int size, int device) {
  std::strncpy(name, device == 5 ? "Card" : "another", static_cast<size_t>(size));
  return 0;
}
EXPORTED int cuDeviceTotalMem_v2(size_t* bytes, int device) {
  *bytes = device == 5 ? size_t{6} << 30 : 0;
  return 0;
}
EXPORTED int cuDeviceGetAttribute(int* value, int attribute, int device) {
  *value = device != 5 ? 0 : attribute == 75 ? 8 : attribute == 76 ? 7 : 0;
  return 0;
}
EXPORTED int cuGetErrorString(int, const char** text) {
  *text = "no error";
  return 0;
}
