// The passes for values and planes in the memory of the host, over any executor, and the renderer "blocks" over it. On the
// CPU the kernels run as loops, so that machines without a card test them; that is slower than the renderer "cpu". Includes
// neither the table of a layer nor messages of errors, which nvcc does not compile: blocks_renderer.cpp is between it and
// Renderer.
#pragma once

#include <map>
#include <memory>
#include <string>

#include "core/render/raster/blocks/pass_kernels.h"

namespace vitrine::blocks {

class BlockPass {
 public:
  virtual ~BlockPass() = default;
  // All pointers are of the host. Returns the number of instances. Throws ExecutorFailure, as reverse() does.
  virtual uint32_t forward(const PassScene& scene, const PixelPlanes& out) = 0;
  // Of the last forward(). Writes all values of `out`.
  virtual void reverse(const GradientPlanes& in, const SurfelGradients& out) = 0;
};

template <class Executor>
class ExecutorPass final : public BlockPass {
 public:
  explicit ExecutorPass(const Executor& executor) : executor_(executor) {}

  uint32_t forward(const PassScene& here, const PixelPlanes& out) override {
    scene_ = here;
    const size_t pixels = here.pixels(), features = static_cast<size_t>(here.features);
    scene_.surfels = surfels_there(here.surfels);
    scene_.wanted = uploaded(wanted_, here.wanted, pixels);
    planes_.resize((features + 4) * pixels);
    fragments_.resize(pixels);
    evaluated_.resize(pixels);
    PixelPlanes there{};
    for (size_t c = 0; c < features; ++c) there.features[c] = planes_.data() + c * pixels;
    float* next = planes_.data() + features * pixels;
    for (float** plane : {&there.zdepth, &there.alpha, &there.median_z, &there.distortion}) {
      *plane = next;
      next += pixels;
    }
    there.fragments = fragments_.data();
    there.evaluated = evaluated_.data();
    kernels_.forward(executor_, scene_, there);
    for (size_t c = 0; c < features; ++c) executor_.download(out.features[c], there.features[c], pixels);
    executor_.download(out.zdepth, there.zdepth, pixels);
    executor_.download(out.alpha, there.alpha, pixels);
    executor_.download(out.median_z, there.median_z, pixels);
    if (here.distortion) executor_.download(out.distortion, there.distortion, pixels);
    executor_.download(out.fragments, there.fragments, pixels);
    executor_.download(out.evaluated, there.evaluated, pixels);
    return kernels_.instances();
  }

  void reverse(const GradientPlanes& here, const SurfelGradients& out) override {
    const size_t pixels = scene_.pixels();
    GradientPlanes there{};
    for (int c = 0; c < scene_.features; ++c) there.features[c] = uploaded(gradients_[c], here.features[c], pixels);
    there.zdepth = uploaded(gradients_[kMaxFeatures], here.zdepth, pixels);
    there.alpha = uploaded(gradients_[kMaxFeatures + 1], here.alpha, pixels);
    there.median_z = uploaded(gradients_[kMaxFeatures + 2], here.median_z, pixels);
    there.distortion = uploaded(gradients_[kMaxFeatures + 3], here.distortion, pixels);
    there.error = uploaded(gradients_[kMaxFeatures + 4], here.error, pixels);
    // One array of the executor for each array of the host.
    struct Copy {
      float* SurfelGradients::*field;
      size_t width;
    };
    const Copy copies[] = {{&SurfelGradients::mean, 3},
                           {&SurfelGradients::rotation, 4},
                           {&SurfelGradients::log_scale, 2},
                           {&SurfelGradients::opacity, 1},
                           {&SurfelGradients::sh_dc, 3},
                           {&SurfelGradients::sh_rest, scene_.surfels.sh_rest_width},
                           {&SurfelGradients::screen_gradient, 1},
                           {&SurfelGradients::weight, 1},
                           {&SurfelGradients::error, 1}};
    SurfelGradients results{};
    const size_t n = scene_.surfels.count;
    size_t array = 0;
    const auto room = [&](size_t width) {
      results_[array].resize(width * n);
      return results_[array++].data();
    };
    for (const Copy& c : copies) results.*c.field = room(c.width);
    for (size_t m = 0; m < 4; ++m) results.material[m] = out.material[m] == nullptr ? nullptr : room(m == 0 ? 3 : 1);
    kernels_.reverse(executor_, scene_, fragments_.data(), there, results);
    for (const Copy& c : copies) executor_.download(out.*c.field, results.*c.field, c.width * n);
    for (size_t m = 0; m < 4; ++m)
      if (out.material[m] != nullptr) executor_.download(out.material[m], results.material[m], (m == 0 ? 3 : 1) * n);
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
  PassKernels<Executor> kernels_;
  PassScene scene_{};  // in the executor's memory
  Array<float> values_[10], planes_, gradients_[kMaxFeatures + 5], results_[13];
  Array<uint8_t> wanted_;
  Array<uint32_t> fragments_, evaluated_;
};

}  // namespace vitrine::blocks

namespace vitrine {

class Renderer;

std::unique_ptr<Renderer> make_blocks_renderer(std::unique_ptr<blocks::BlockPass> pass);

// On the CPU. seed 0: blocks in parallel. Otherwise blocks, and threads within each phase, run one by one in an order that the
// seed shuffles; the result is the same.
std::unique_ptr<Renderer> make_blocks_renderer(uint64_t shuffle_seed = 0);

// On the CUDA device that CUDA chooses. Only programs that link the target vitrine_cuda have it; throws blocks::ExecutorFailure
// if the machine has none. `kernel_ms`: times of kernels by name, added up; waits for each kernel. Must outlive the pass.
std::unique_ptr<blocks::BlockPass> make_cuda_pass(std::map<std::string, double>* kernel_ms = nullptr);

}  // namespace vitrine
