// Part of every program: where the processor lacks the instructions that the program was compiled for, it ends with a sentence and the
// exit code of a missing device, before a static initialiser or main() runs into one of them. Compiled for any x86-64.
#include <cstring>

#include <unistd.h>

namespace {

__attribute__((constructor(101))) void require_avx2() {
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") && __builtin_cpu_supports("bmi2")) return;
  const char* const text =
      "error: this processor has no AVX2\n"
      "  why    vitrine is compiled for x86-64-v3: Intel since 2013 (not all Celerons and Pentiums), AMD since 2015\n"
      "  try    another machine; a virtual machine: let it have the processor of its host\n";
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text, std::strlen(text));
  _exit(8);
}

}  // namespace
