// Rasteriser interface for 2D Gaussian surfels, forward and backward, with one virtual call per pass. Back ends: "reference"
// (double, O(pixels x surfels), the executable specification), "cpu" (tiles, SIMD, threads) and "blocks" (for a GPU). Fragments
// are composited in exact depth order per pixel, ties by surfel index. README.md in this folder derives the mathematics.
#pragma once

#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "core/render/raster/raster_desc.h"
#include "core/scene/surfels/layers.h"

namespace vitrine {

// Per-surfel outputs of a backward pass in addition to the gradients of the layer.
struct SurfelStatistics {
  std::vector<float> screen_gradient;  // norm of the projected centre's gradient, in half images (Huang et al. 2024)
  std::vector<float> weight;           // sum over pixels of the blending weight w
  std::vector<float> error;            // sum over pixels of w * error_image, if given
  void reset(size_t surfels) {
    for (auto* values : {&screen_gradient, &weight, &error}) values->assign(surfels, 0.f);
  }
};

struct BackwardInput {
  const RasterImages* gradients = nullptr;  // dL/d(plane); an empty plane counts as zero and costs nothing
  std::span<const float> error_image = {};  // [h, w] or empty
};

// Work of the last forward(). A fragment is an evaluated pair of pixel and surfel with alpha >= 1/255.
struct RasterCounts {
  uint64_t surfels = 0;    // visible
  uint64_t instances = 0;  // (tile, surfel) pairs
  uint64_t fragments = 0;
  uint64_t lanes = 0;  // pixels evaluated to find the fragments
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  // Renders `layer`; keeps the state for backward() until the next forward(). `layer` must outlive backward().
  virtual void forward(const SplatLayer& layer, const RasterDesc& desc, RasterImages& out) = 0;
  // Adds gradients of the last forward() to `grad` (same shape as the layer, raw values) and, if given, to `statistics`.
  virtual void backward(const BackwardInput& input, SplatLayer& grad, SurfelStatistics* statistics) = 0;
  virtual RasterCounts counts() const = 0;
  virtual std::string_view name() const = 0;
  // Part of cache keys: results with different tags may differ in the last bits ("reference", "cpu-avx2", "cpu-avx512",
  // "cuda-2").
  virtual std::string_view numerics_tag() const = 0;
};

// Cpu: on the device that use_device() chose (device.h), if it chose one. Blocks: the kernels for a GPU as loops on the CPU
// (blocks/block_kernel.h); for tests.
enum class Backend { Reference, Cpu, Blocks };
// Instruction set of Backend::Cpu. Best: the widest that the machine supports, unless the environment variable VITRINE_SIMD is
// "avx2" or "avx512".
enum class Simd { Best, Avx2, Avx512 };
bool machine_has(Simd simd);
// Throws Error{Device} if the machine does not support `simd`. Best: an instruction set that is named is that of the CPU.
std::unique_ptr<Renderer> make_renderer(Backend backend, Simd simd = Simd::Best);

}  // namespace vitrine
