// Registers and memory of the kernels for a GPU, as the CUDA compiler lists them. Skipped in a build without one.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <utility>

#include "core/foundation/base/file.h"

namespace vitrine {
namespace {

struct KernelUsage {
  int registers = -1, stack = -1, spilled = -1;  // registers of a thread; bytes of a thread
};

// By the name of the kernel (mangled) and of the architecture; from the lines that `ptxas -v` prints.
std::map<std::pair<std::string, std::string>, KernelUsage> read_usage(const std::string& text) {
  std::map<std::pair<std::string, std::string>, KernelUsage> all;
  const std::regex entry("Compiling entry function '(\\w+)' for '(\\w+)'"), registers("Used (\\d+) registers");
  const std::regex memory("(\\d+) bytes stack frame, (\\d+) bytes spill stores, (\\d+) bytes spill loads");
  KernelUsage* current = nullptr;
  std::istringstream lines(text);
  std::smatch m;
  for (std::string line; std::getline(lines, line);) {
    if (std::regex_search(line, m, entry)) current = &all[{m[1], m[2]}];
    if (current == nullptr) continue;
    if (std::regex_search(line, m, registers)) current->registers = std::stoi(m[1]);
    if (std::regex_search(line, m, memory)) {
      current->stack = std::stoi(m[1]);
      current->spilled = std::stoi(m[2]) + std::stoi(m[3]);
    }
  }
  return all;
}

TEST(DeviceUsage, ReadsTheLinesOfTheCompiler) {
  const auto usage = read_usage(
      "ptxas info    : Compiling entry function '_Z1fv' for 'sm_80'\nptxas info    : Function properties for _Z1fv\n"
      "    8 bytes stack frame, 4 bytes spill stores, 12 bytes spill loads\n"
      "ptxas info    : Used 53 registers, used 0 barriers, 400 bytes cmem[0]\n");
  ASSERT_EQ(usage.size(), 1u);
  const KernelUsage u = usage.at({"_Z1fv", "sm_80"});
  EXPECT_EQ(u.registers, 53);
  EXPECT_EQ(u.stack, 8);
  EXPECT_EQ(u.spilled, 16);
}

// Each kernel of a name (with the beginning of its template arguments, mangled) needs at most so many registers, keeps all its
// values in them, and uses no stack but the bytes of its own arrays.
void expect_registers(const char* file_name, const std::map<std::string, int>& most, int stack = 0) {
  const fs::path file = fs::path(VITRINE_BIN_DIR).parent_path() / "device" / file_name;
  if (!fs::exists(file)) GTEST_SKIP() << "built without a CUDA compiler";
  const auto usage = read_usage(read_file(file));
  for (const auto& [kernel, registers] : most)
    for (const std::string architecture : {"sm_80", "sm_90"}) {
      SCOPED_TRACE(kernel + " for " + architecture);
      const std::string name =
          std::to_string(kernel.substr(0, kernel.find("ILi")).size()) + kernel;  // the mangled name has its length
      int found = 0, worst = 0;
      for (const auto& [key, u] : usage) {
        if (key.first.find(name) == key.first.npos || key.second != architecture) continue;
        ++found;
        worst = std::max(worst, u.registers);
        EXPECT_LE(u.stack, stack);
        EXPECT_EQ(u.spilled, 0);
      }
      EXPECT_GT(found, 0);
      EXPECT_GT(worst, 0);
      EXPECT_LE(worst, registers);
      std::cout << kernel << " " << architecture << ": " << worst << " registers\n";
    }
}

// A multiprocessor has 65536 registers: threads of 32 registers fill it (2048 threads), with 64 it runs half as many.
TEST(DeviceUsage, FormulasStayInTheirRegisters) {
  expect_registers("kernels_on_device.usage", {{"project_surfels", 32},
                                               {"project_surfels_vjp", 56},
                                               {"shade_surfels", 40},
                                               {"blend_pixels", 40},
                                               {"blend_pixels_vjp", 64}});
}

// Blending keeps the pixel's sums and eight waiting fragments, the reverse of a surfel its coefficients: two blocks of 256
// threads.
TEST(DeviceUsage, KernelsOfThePassesStayInTheirRegisters) {
  expect_registers("cuda_pass.usage", {{"ProjectKernel", 72},
                                       {"ScanKernel", 48},
                                       {"AddTotalsKernel", 32},
                                       {"InstanceKernel", 40},
                                       {"OwnerKernel", 32},
                                       {"RadixCountKernel", 40},
                                       {"RadixMoveKernel", 40},
                                       {"TileBeginKernel", 32},
                                       {"PlaneSinkILi3", 85},
                                       {"PlaneSinkILi6", 128},
                                       {"PlaneSinkILi12", 128},
                                       {"FragmentSink", 85},
                                       {"ClearKernel", 32},
                                       {"MaskCountKernel", 32},
                                       {"PixelReverseKernelILi3", 64},
                                       {"PixelReverseKernelILi12", 72},
                                       {"InstanceReverseKernelILi3", 64},
                                       {"InstanceReverseKernelILi12", 72},
                                       {"SurfelReverseKernel", 128}});
}

// A traversal keeps the sixteen nearest hits, and on its stack 43 boxes with their distances.
TEST(DeviceUsage, KernelsOfRaysStayInTheirRegisters) {
  expect_registers("cuda_trace.usage", {{"TraceKernelILi0", 128}, {"TraceKernelILi3", 128}}, 43 * 8);
  expect_registers("cuda_trace.usage", {{"RayReverseKernelILi0", 96},
                                        {"RayReverseKernelILi3", 96},
                                        {"PlaceBeginKernel", 32},
                                        {"RunCountKernel", 32},
                                        {"RunPlaceKernel", 32},
                                        {"RunSumKernel", 40},
                                        {"PlaceSumKernel", 32},
                                        {"TracedSurfelKernel", 64}});
}

TEST(DeviceUsage, KernelsOfTrainingStayInTheirRegisters) {
  expect_registers("cuda_steps.usage", {{"DisplayKernel", 40},
                                       {"DisplayReverseKernel", 40},
                                       {"TreeSumKernel", 32},
                                       {"L1Kernel", 40},
                                       {"SsimKernel", 64},
                                       {"SsimGradientKernel", 64},
                                       {"AdamSurfelKernel", 40},
                                       {"AdamUpdateKernel", 40},
                                       {"StatisticsKernel", 32},
                                       {"FactorKernel", 40},
                                       {"LeastColourKernel", 32},
                                       {"ChanceKernel", 40},
                                       {"ChancePartsKernel", 32},
                                       {"SlotKernel", 32},
                                       {"ParentKernel", 32},
                                       {"DivideKernel", 64},
                                       {"TargetKernel", 32},
                                       {"ScaleKernel", 32},
                                       {"PixelWeightKernel", 32},
                                       {"CopyKernel", 32}});
}

TEST(DeviceUsage, KernelsOfLossesStayInTheirRegisters) {
  expect_registers("cuda_steps.usage", {{"FillKernel", 32},
                                        {"GatherKernel", 32},
                                        {"NormalConsistencyKernel", 40},
                                        {"DepthGradientKernel", 40},
                                        {"ActivationKernel", 32},
                                        {"SpecularMaskKernel", 32},
                                        {"CrossEntropyKernel", 32},
                                        {"TargetNormalKernel", 40},
                                        {"NoiseKernel", 40}});
}

}  // namespace
}  // namespace vitrine
