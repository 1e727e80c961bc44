// The choice of the device, with the kernels as loops in its place, and the errors of a device that is missing or too small.
#include "core/render/raster/device.h"

#include <gtest/gtest.h>

#include "core/render/raster/blocks/block_pass.h"
#include "core/render/raster/renderer.h"
#include "tests/support/error_of.h"
#include "tests/support/tiny_scenes.h"

namespace vitrine {
namespace {

using blocks::BlockLoops, blocks::ExecutorPass;

std::unique_ptr<blocks::BlockPass> loops() { return std::make_unique<ExecutorPass<BlockLoops>>(BlockLoops()); }

class DeviceChoice : public testing::Test {
 protected:
  ~DeviceChoice() override {
    provide_device(before_);
    use_device(Device::Cpu);
  }
  static std::string tag() { return std::string(make_renderer(Backend::Cpu)->numerics_tag()); }
  DevicePassMaker before_ = provide_device(nullptr);
  const std::string cpu_ = tag();
};

TEST_F(DeviceChoice, WithoutKernelsIsAnErrorOrTheCpu) {
  EXPECT_FALSE(has_device_kernels());
  const Error e = error_of([] { use_device(Device::Cuda); });
  EXPECT_EQ(exit_code(e.kind()), 8);
  EXPECT_EQ(e.detail().code, "NO_KERNELS");
  EXPECT_FALSE(e.detail().hint.empty());
  EXPECT_NE(use_device(Device::Auto).find("no kernels"), std::string::npos);
  EXPECT_EQ(tag(), cpu_);
}

TEST_F(DeviceChoice, WithoutACardIsAnErrorOrTheCpu) {
  provide_device([]() -> std::unique_ptr<blocks::BlockPass> { throw blocks::ExecutorFailure("the slot is empty"); });
  const Error e = error_of([] { use_device(Device::Cuda); });
  EXPECT_EQ(exit_code(e.kind()), 8);
  EXPECT_EQ(e.detail().code, "NO_DEVICE");
  EXPECT_EQ(e.detail().why, "the slot is empty");
  EXPECT_NE(use_device(Device::Auto).find("the slot is empty"), std::string::npos);
  EXPECT_EQ(tag(), cpu_);
}

TEST_F(DeviceChoice, RenderersAreThoseOfTheDevice) {
  provide_device(loops);
  EXPECT_EQ(tag(), cpu_) << "before one is chosen";
  for (const Device device : {Device::Cuda, Device::Auto}) {
    EXPECT_EQ(use_device(device), "");
    EXPECT_EQ(tag(), "cuda-2");
    EXPECT_EQ(make_renderer(Backend::Reference)->numerics_tag(), "reference");
    EXPECT_EQ(make_renderer(Backend::Cpu, Simd::Avx2)->numerics_tag(), "cpu-avx2");
  }
  use_device(Device::Cpu);
  EXPECT_EQ(tag(), cpu_);
}

// A device with 64 KiB.
struct SmallLoops : BlockLoops {
  template <class T>
  class Array : public std::vector<T> {
   public:
    void resize(size_t size) {
      constexpr size_t kAll = 1 << 16;
      static size_t held = 0;  // by arrays of this type
      if (held + size * sizeof(T) > kAll) throw blocks::ExecutorMemory(size * sizeof(T), held, kAll - held);
      held += (size - this->size()) * sizeof(T);
      std::vector<T>::resize(size);
    }
  };
};

TEST(DeviceMemory, TooLittleIsAnErrorWithWhatMayFit) {
  const TinyScene scene = cloud_scene("cloud", 300, 200, 150, 0.1, 0.8, 22);
  const auto renderer = make_blocks_renderer(std::make_unique<ExecutorPass<SmallLoops>>(SmallLoops()));
  RasterImages images;
  const Error e = error_of([&] { renderer->forward(scene.layer, scene.desc, images); });
  EXPECT_EQ(exit_code(e.kind()), 6);
  EXPECT_EQ(e.detail().code, "DEVICE_MEMORY");
  EXPECT_EQ(e.detail().where, "300 surfels, 200 x 150 pixels");
  EXPECT_NE(e.detail().why.find("are needed, "), std::string::npos);
  EXPECT_NE(e.detail().why.find(" are free"), std::string::npos);
  EXPECT_NE(e.detail().hint.find(" surfels, or a picture of "), std::string::npos);
}

// A device whose scans find more than 32 bits count.
struct CrowdedLoops : BlockLoops {
  template <class T>
  T read(const T*) const {
    return T(-1);
  }
};

TEST(DeviceMemory, MorePairsThan32BitsCountAreAnError) {
  const TinyScene scene = cloud_scene("cloud", 30, 20, 15, 0.1, 0.8, 22);
  const auto renderer = make_blocks_renderer(std::make_unique<ExecutorPass<CrowdedLoops>>(CrowdedLoops()));
  RasterImages images;
  const Error e = error_of([&] { renderer->forward(scene.layer, scene.desc, images); });
  EXPECT_EQ(exit_code(e.kind()), 6);
  EXPECT_EQ(e.detail().code, "DEVICE_OVERFLOW");
  EXPECT_EQ(e.detail().why, "there are more than 4294963199 pairs of a surfel and a tile");
}

TEST(DeviceMemory, SumsBeyond32BitsStayAtTheLargestNumber) {
  for (const uint64_t seed : {0, 3})
    for (const uint32_t size : {2u, 300u, 5000u}) {
      BlockLoops executor(seed);
      blocks::ScanMemory<BlockLoops> memory;
      std::vector<uint32_t> values(size, ~0u / size), out(size);
      EXPECT_LT(executor.read(blocks::exclusive_scan(executor, memory, values.data(), out.data(), size)), ~0u);
      values.back() += size + 1;
      EXPECT_EQ(executor.read(blocks::exclusive_scan(executor, memory, values.data(), out.data(), size)), ~0u);
    }
  EXPECT_EQ(blocks::checked_count(blocks::kMostItems, "items"), blocks::kMostItems);
  EXPECT_THROW(blocks::checked_count(blocks::kMostItems + 1, "items"), blocks::ExecutorOverflow);
}

TEST(GraphicsCards, AreFoundThroughALibraryOfADriver) {
  const GraphicsCardSearch none = find_graphics_card("libno_such_driver.so.1"), other = find_graphics_card("libm.so.6");
  EXPECT_FALSE(none.card);
  EXPECT_EQ(none.why_not, "there is no NVIDIA driver (libno_such_driver.so.1 is not installed)");
  EXPECT_FALSE(other.card);
  EXPECT_EQ(other.why_not, "libm.so.6 is not the library of an NVIDIA driver");
  const std::string folder = VITRINE_BIN_DIR;
  const GraphicsCardSearch found = find_graphics_card((folder + "/libfake_driver.so").c_str());
  ASSERT_TRUE(found.card) << found.why_not;
  EXPECT_EQ(found.card->name, "Card");
  EXPECT_EQ(found.card->memory_bytes, size_t{6} << 30);
  EXPECT_EQ(found.card->capability, 87);
  EXPECT_EQ(found.card->driver, 12040);
}

}  // namespace
}  // namespace vitrine
