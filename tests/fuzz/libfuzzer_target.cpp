// One libFuzzer target: the build names the entry function.
#include "tests/fuzz/formats.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  vitrine::VITRINE_FUZZ_ENTRY({data, size});
  return 0;
}
