// The forward pass for values and planes in the memory of the host, over any executor, and the renderer "blocks" over it. On the
// CPU the kernels run as loops, so that machines without a card test them; that is slower than the renderer "cpu". Includes
// neither the table of a layer nor messages of errors, which nvcc does not compile: blocks_renderer.cpp is between it and
// Renderer.
#pragma once

#include <map>
#include <memory>
#include <stdexcept>
#include <string>

#include "core/render/raster/blocks/forward_pass.h"

namespace vitrine::blocks {

struct PassInput {
  SurfelArrays surfels;
  BlockView view;
  int features;  // number of blended channels: 3, 6 or 12
  bool distortion;
  const uint8_t* wanted;  // [h, w]; null: all pixels
};

// The device failed or is missing; the text names what and why.
struct ExecutorFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class BlockPass {
 public:
  virtual ~BlockPass() = default;
  // All pointers are of the host. Returns the number of instances. Throws ExecutorFailure.
  virtual uint32_t run(const PassInput& input, const PixelPlanes& out) = 0;
};

template <class Executor>
class ExecutorPass final : public BlockPass {
 public:
  explicit ExecutorPass(const Executor& executor) : executor_(executor) {}

  uint32_t run(const PassInput& input, const PixelPlanes& out) override {
    const size_t pixels = static_cast<size_t>(input.view.width) * static_cast<size_t>(input.view.height);
    const uint8_t* const wanted = uploaded(wanted_, input.wanted, pixels);
    planes_.resize((static_cast<size_t>(input.features) + 4) * pixels);
    work_.resize(pixels);
    PixelPlanes there{};
    float* next = planes_.data();
    for (int c = 0; c < input.features; ++c, next += pixels) there.features[c] = next;
    for (float** plane : {&there.zdepth, &there.alpha, &there.median_z, &there.distortion}) {
      *plane = next;
      next += pixels;
    }
    there.work = work_.data();
    pass_.run(executor_, surfels_there(input.surfels), input.view, input.features, input.distortion, wanted, there);
    for (int c = 0; c < input.features; ++c) executor_.download(out.features[c], there.features[c], pixels);
    executor_.download(out.zdepth, there.zdepth, pixels);
    executor_.download(out.alpha, there.alpha, pixels);
    executor_.download(out.median_z, there.median_z, pixels);
    if (input.distortion) executor_.download(out.distortion, there.distortion, pixels);
    executor_.download(out.work, there.work, pixels);
    return pass_.instances();
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;

  template <class T>
  const T* uploaded(Array<T>& to, const T* from, size_t size) {
    if (from == nullptr) return nullptr;
    to.resize(size);
    executor_.upload(to.data(), from, size);
    return to.data();
  }
  SurfelArrays surfels_there(const SurfelArrays& here) {
    const size_t n = here.count;
    SurfelArrays there{};
    there.mean = uploaded(values_[0], here.mean, 3 * n);
    there.rotation = uploaded(values_[1], here.rotation, 4 * n);
    there.log_scale = uploaded(values_[2], here.log_scale, 2 * n);
    there.opacity = uploaded(values_[3], here.opacity, n);
    there.sh_dc = uploaded(values_[4], here.sh_dc, 3 * n);
    there.sh_rest = uploaded(values_[5], here.sh_rest, here.sh_rest_width * n);
    for (size_t m = 0; m < 4; ++m) there.material[m] = uploaded(values_[6 + m], here.material[m], (m == 0 ? 3 : 1) * n);
    there.sh_rest_width = here.sh_rest_width;
    there.count = here.count;
    return there;
  }

  Executor executor_;
  ForwardPass<Executor> pass_;
  Array<float> values_[10], planes_;
  Array<uint8_t> wanted_;
  Array<PixelWork> work_;
};

}  // namespace vitrine::blocks

namespace vitrine {

class Renderer;

// There is no reverse pass yet: backward() is a programming error.
std::unique_ptr<Renderer> make_blocks_renderer(std::unique_ptr<blocks::BlockPass> pass);

// On the CPU. seed 0: blocks in parallel. Otherwise blocks, and threads within each phase, run one by one in an order that the
// seed shuffles; the result is the same.
std::unique_ptr<Renderer> make_blocks_renderer(uint64_t shuffle_seed = 0);

// On the CUDA device that CUDA chooses. Only programs that link the target vitrine_cuda have it; throws blocks::ExecutorFailure
// if the machine has none. `kernel_ms`: times of kernels by name, added up; waits for each kernel. Must outlive the pass.
std::unique_ptr<blocks::BlockPass> make_cuda_pass(std::map<std::string, double>* kernel_ms = nullptr);

}  // namespace vitrine
