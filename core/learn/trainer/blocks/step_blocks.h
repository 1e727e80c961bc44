// Training steps of one opaque layer in the memory of a device: picture, display, L1 and D-SSIM against a photo, reverse,
// statistics, Adam; and relocation. Besides two counts, which size arrays, nothing is copied from step to step. Over any executor
// (block_kernel.h); the bytes are the same on all of them.
#pragma once

#include <deque>

#include "core/learn/loss/blocks/picture_loss_kernels.h"
#include "core/learn/optim/blocks/relocate_kernels.h"
#include "core/render/model/blocks/display_kernels.h"
#include "core/render/raster/blocks/pass_kernels.h"

namespace vitrine::blocks {

// A photo with its camera.
struct StepPhoto {
  BlockView view;
  float gain[3];
  size_t target;  // of StepBlocks::add_photo
};

template <class Executor>
class StepBlocks {
 public:
  // Mean, rotation, log scale, opacity, harmonics: the attributes of an opaque layer.
  static constexpr uint32_t kColumns = 6;
  using Rates = std::array<float, kColumns>;
  static constexpr float kRarest = 4;  // longest steps of surfels that few photos show

  // `here`: of the host. `cap`: most surfels after relocations.
  StepBlocks(const Executor& executor, const SurfelArrays& here, uint32_t cap, const AdamDesc& adam = {})
      : executor_(executor), adam_(executor_, adam), count_(here.count), cap_(cap), rest_(here.sh_rest_width) {
    const float* const from[] = {here.mean, here.rotation, here.log_scale, here.opacity, here.sh_dc, here.sh_rest};
    for (uint32_t c = 0; c < kColumns; ++c) {
      const size_t all = size_t{width(c)} * cap;
      for (auto* arrays : {&value_, &gradient_, &m_, &v_}) (*arrays)[c].resize(all);
      executor_.upload(value_[c].data(), from[c], size_t{width(c)} * count_);
      clear(m_[c].data(), all);
      clear(v_[c].data(), all);
    }
    for (auto* arrays : {&statistics_, &sums_})
      for (auto& values : *arrays) values.resize(cap);
    active_.resize(cap);
    for (auto* values : {&steps_, &seen_}) values->resize(cap);
    for (auto* values : {&share_, &rarity_, &distance_}) values->resize(cap);
    executor_.upload(share_.data(), std::vector<float>(cap, 1.f).data(), cap);
    clear(steps_.data(), cap);
    clear_sums();
  }

  // [3,h,w], display-referred. Returns its number.
  size_t add_photo(const std::vector<float>& srgb) {
    photos_.emplace_back().resize(srgb.size());
    executor_.upload(photos_.back().data(), srgb.data(), srgb.size());
    return photos_.size() - 1;
  }

  void step(const StepPhoto& photo, const Rates& rates, const PictureLossWeights& weights) {
    const PassScene scene{arrays(), photo.view, 3, false, nullptr};
    const uint32_t pixels = scene.pixels();
    const PixelPlanes planes = forward(scene, photo);
    const PicturePair pair{srgb_.data(), photos_[photo.target].data(), nullptr, static_cast<uint32_t>(photo.view.width),
                           static_cast<uint32_t>(photo.view.height)};
    loss_.evaluate(executor_, pair, weights, picture_gradient_.data(), error_.data());
    display(DisplayReverseKernel{planes.features[0], picture_gradient_.data(), {}, pixels}, photo);
    GradientPlanes in{};
    for (size_t c = 0; c < 3; ++c) in.features[c] = picture_gradient_.data() + c * pixels;
    in.error = error_.data();
    SurfelGradients out{};
    out.mean = gradient_[0].data();
    out.rotation = gradient_[1].data();
    out.log_scale = gradient_[2].data();
    out.opacity = gradient_[3].data();
    out.sh_dc = gradient_[4].data();
    out.sh_rest = gradient_[5].data();
    out.screen_gradient = statistics_[0].data();
    out.weight = statistics_[1].data();
    out.error = statistics_[2].data();
    kernels_.reverse(executor_, scene, planes.fragments, in, out);
    launch(StatisticsKernel{out.weight, out.error, out.screen_gradient, accumulator(), count_});
    const float* share_sum = tree_sum(executor_, share_sum_, share_.data(), count_);
    launch(FactorKernel{out.weight, share_.data(), share_sum, value_[0].data(), kRarest, active_.data(), rarity_.data(),
                        distance_.data(), count_});
    adam_.step(executor_, columns(rates), active_.data(), {rarity_.data(), nullptr, distance_.data()}, steps_.data(), count_);
    launch(LeastColourKernel{active_.data(), value_[4].data(), count_});
  }

  // Relocates and grows up to the cap, and starts the statistics again. Waits for the device.
  typename RelocateBlocks<Executor>::Counts relocate(uint64_t seed, uint64_t step, double idle_weight, double growth) {
    const auto counts =
        relocate_.run(executor_, {seed, step, idle_weight, growth, cap_}, columns({}), steps_.data(), accumulator(), count_);
    count_ += counts.added;
    clear_sums();
    return counts;
  }
  uint32_t surfels() const { return count_; }

  // Display-referred, [3,h,w], from the device.
  std::vector<float> picture(const StepPhoto& photo) {
    const PassScene scene{arrays(), photo.view, 3, false, nullptr};
    forward(scene, photo);
    std::vector<float> srgb(size_t{3} * scene.pixels());
    executor_.download(srgb.data(), srgb_.data(), srgb.size());
    return srgb;
  }
  // Of the last step, before it. Waits for the device.
  typename PictureLossBlocks<Executor>::Values losses() { return loss_.values(executor_); }
  // Column by column, from the device.
  std::vector<std::vector<float>> values() {
    std::vector<std::vector<float>> all;
    for (uint32_t c = 0; c < kColumns; ++c) {
      all.emplace_back(size_t{width(c)} * count_);
      executor_.download(all.back().data(), value_[c].data(), all.back().size());
    }
    return all;
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;

  uint32_t width(uint32_t column) const {
    constexpr uint32_t kWidths[] = {3, 4, 2, 1, 3};
    return column < 5 ? kWidths[column] : rest_;
  }
  AdamColumns columns(const Rates& rates) {
    AdamColumns columns{};
    for (uint32_t c = 0; c < kColumns; ++c)
      columns.column[c] = {gradient_[c].data(), m_[c].data(), v_[c].data(), value_[c].data(), width(c), rates[c], c < 4, c == 0};
    return columns;
  }
  AccumulatorArrays accumulator() { return {sums_[0].data(), sums_[1].data(), sums_[2].data(), share_.data(), seen_.data()}; }
  void clear_sums() {
    for (auto& values : sums_) clear(values.data(), cap_);
    clear(seen_.data(), cap_);
  }
  template <class T>
  void clear(T* values, size_t size) {
    executor_.launch(ClearKernel<T>{values, size}, blocks_for(size, ClearKernel<T>::kThreads));
  }
  // A thread for each surfel.
  template <class Kernel>
  void launch(const Kernel& kernel) {
    executor_.launch(kernel, blocks_for(kernel.surfels, Kernel::kThreads));
  }
  SurfelArrays arrays() const {
    SurfelArrays s{};
    s.mean = value_[0].data();
    s.rotation = value_[1].data();
    s.log_scale = value_[2].data();
    s.opacity = value_[3].data();
    s.sh_dc = value_[4].data();
    s.sh_rest = value_[5].data();
    s.sh_rest_width = rest_;
    s.count = count_;
    return s;
  }
  PixelPlanes planes_of(uint32_t pixels) {
    planes_.resize(size_t{7} * pixels);
    counts_.resize(size_t{2} * pixels);
    srgb_.resize(size_t{3} * pixels);
    picture_gradient_.resize(size_t{3} * pixels);
    error_.resize(pixels);
    PixelPlanes p{};
    for (size_t c = 0; c < 3; ++c) p.features[c] = planes_.data() + c * pixels;
    float** const others[] = {&p.zdepth, &p.alpha, &p.median_z, &p.distortion};
    for (size_t k = 0; k < 4; ++k) *others[k] = planes_.data() + (3 + k) * pixels;
    p.fragments = counts_.data();
    p.evaluated = counts_.data() + pixels;
    return p;
  }
  PixelPlanes forward(const PassScene& scene, const StepPhoto& photo) {
    const PixelPlanes planes = planes_of(scene.pixels());
    kernels_.forward(executor_, scene, planes);
    display(DisplayKernel{planes.features[0], srgb_.data(), {}, scene.pixels()}, photo);
    return planes;
  }
  template <class Kernel>
  void display(Kernel kernel, const StepPhoto& photo) {
    for (size_t c = 0; c < 3; ++c) kernel.gain[c] = photo.gain[c];
    executor_.launch(kernel, blocks_for(kernel.pixels, Kernel::kThreads));
  }

  Executor executor_;
  PassKernels<Executor> kernels_;
  PictureLossBlocks<Executor> loss_;
  AdamBlocks<Executor> adam_;
  RelocateBlocks<Executor> relocate_;
  TreeSumMemory<Executor> share_sum_;
  uint32_t count_, cap_, rest_;
  std::array<Array<float>, kColumns> value_, gradient_, m_, v_;
  std::array<Array<float>, 3> statistics_, sums_;  // of the picture; since the last relocation
  Array<uint8_t> active_;
  Array<uint32_t> steps_, seen_, counts_;
  Array<float> share_, rarity_, distance_, planes_, srgb_, picture_gradient_, error_;
  std::deque<Array<float>> photos_;
};

}  // namespace vitrine::blocks
