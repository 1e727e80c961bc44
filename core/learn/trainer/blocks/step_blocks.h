// Training steps of one opaque layer over any executor (block_kernel.h): picture, display, losses against a photo, reverse,
// statistics, Adam; relocation and the random walk. The state stays in the executor's memory: from step to step only numbers are
// copied, some of which size arrays. The bytes are the same on all executors.
#pragma once

#include <array>
#include <utility>

#include "core/learn/optim/blocks/noise_kernel.h"
#include "core/learn/optim/blocks/relocate_kernels.h"
#include "core/learn/trainer/blocks/photo_store.h"
#include "core/render/model/blocks/display_kernels.h"
#include "core/render/raster/blocks/pass_kernels.h"

namespace vitrine::blocks {

template <class Executor>
class StepBlocks final : public StepPass {
 public:
  explicit StepBlocks(const Executor& executor) : executor_(executor), adam_(executor_, AdamDesc{}) {}

  void put(const StepState& here) override {
    count_ = room_ = here.surfels;
    for_each_array(here, [&](auto& there, auto* from, uint32_t width) {
      there.resize(size_t{width} * count_);
      executor_.upload(there.data(), from, there.size());
    });
    std::copy_n(here.width, kAttributeCount, width_);
  }
  void get(const StepState& here) override {
    for_each_array(here,
                   [&](auto& there, auto* to, uint32_t width) { executor_.download(to, there.data(), size_t{width} * count_); });
  }
  uint32_t surfels() const override { return count_; }

  std::optional<StepReport> step(const StepDesc& desc, const StepPhoto& photo) override {
    const PassScene scene{arrays(), desc.view, channels_for(desc.losses, photo), desc.losses[BlockLoss::Distortion] != 0.f,
                          nullptr};
    const PixelPlanes planes = forward(scene, desc.gain);
    const std::optional<StepReport> before = report();
    const GradientPlanes in = evaluate(scene, planes, desc, photos_.there(executor_, photo));
    const SurfelGradients out = gradients();
    kernels_.reverse(executor_, scene, planes.fragments, in, out);
    losses_.regularise(executor_, scene.surfels, out);
    descend(desc, out);
    unread_ = true;
    return before;
  }

  std::optional<StepReport> report() override {
    if (!std::exchange(unread_, false)) return std::nullopt;
    const auto values = losses_.values(executor_);
    return StepReport{values.total, values.mean_error, executor_.read(active_sum_), executor_.read(skipped_)};
  }

  Moved relocate(uint64_t seed, uint64_t step, double idle_weight, double growth, uint32_t cap) override {
    reserve(grown_to(count_, growth, cap));
    const auto counts =
        relocate_.run(executor_, {seed, step, idle_weight, growth, cap}, columns({}), steps_.data(), accumulator(), count_);
    count_ += counts.added;
    for (auto* values : {&weight_, &error_, &screen_gradient_}) clear(values->data(), count_);
    clear(seen_.data(), count_);
    return {counts.relocated, counts.added};
  }

  void walk(float strength, uint64_t seed, uint64_t step) override {
    add_position_noise(executor_, arrays(), value_[0].data(), strength, seed, step);
  }

  std::vector<float> picture(const BlockView& view, const float (&gain)[3]) override {
    const PassScene scene{arrays(), view, 3, false, nullptr};
    forward(scene, gain);
    std::vector<float> srgb(size_t{3} * scene.pixels());
    executor_.download(srgb.data(), srgb_.data(), srgb.size());
    return srgb;
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;

  // Attributes with a gradient: the picture of an opaque layer shows no materials.
  static constexpr size_t kLearned = 6;

  // Calls visit(array here, array of the host, floats of a surfel) for each array of the state.
  template <class Visit>
  void for_each_array(const StepState& here, const Visit& visit) {
    for (size_t a = 0; a < kAttributeCount; ++a) {
      visit(value_[a], here.value[a], here.width[a]);
      visit(m_[a], here.m[a], here.width[a]);
      visit(v_[a], here.v[a], here.width[a]);
    }
    visit(weight_, here.weight, 1);
    visit(error_, here.error, 1);
    visit(screen_gradient_, here.screen_gradient, 1);
    visit(share_, here.share, 1);
    visit(steps_, here.steps, 1);
    visit(seen_, here.seen, 1);
  }
  // Room for so many surfels; the state stays.
  void reserve(uint32_t surfels) {
    if (surfels <= room_) return;
    StepState state{};
    std::copy_n(width_, kAttributeCount, state.width);
    for_each_array(state, [&]<class A>(A& array, auto*, uint32_t width) {
      using T = std::remove_cvref_t<decltype(*array.data())>;
      A larger;
      larger.resize(size_t{width} * surfels);
      launch(size_t{width} * count_, CopyKernel<T>{array.data(), larger.data(), size_t{width} * count_});
      array = std::move(larger);
    });
    room_ = surfels;
  }
  static uint32_t grown_to(uint32_t surfels, double growth, uint32_t cap) {
    const double grown = std::min(double{1} * cap, std::ceil(double{1} * surfels * growth));
    return std::max(surfels, static_cast<uint32_t>(grown));
  }

  static bool reads_normals(const LossFactors& losses, const StepPhoto& photo) {
    return losses[BlockLoss::NormalConsistency] != 0.f || (losses[BlockLoss::MonocularNormal] != 0.f && photo.normals != nullptr);
  }
  // Blended channels that the losses read: colour, and normals.
  static int channels_for(const LossFactors& losses, const StepPhoto& photo) { return reads_normals(losses, photo) ? 6 : 3; }

  PixelPlanes forward(const PassScene& scene, const float (&gain)[3]) {
    const size_t pixels = scene.pixels(), features = static_cast<size_t>(scene.features);
    planes_.resize((features + 4) * pixels);
    counts_.resize(2 * pixels);
    srgb_.resize(3 * pixels);
    PixelPlanes p{};
    for (size_t c = 0; c < features; ++c) p.features[c] = planes_.data() + c * pixels;
    float** const others[] = {&p.zdepth, &p.alpha, &p.median_z, &p.distortion};
    for (size_t k = 0; k < 4; ++k) *others[k] = planes_.data() + (features + k) * pixels;
    p.fragments = counts_.data();
    p.evaluated = counts_.data() + pixels;
    kernels_.forward(executor_, scene, p);
    launch(pixels, DisplayKernel{p.features[0], srgb_.data(), {gain[0], gain[1], gain[2]}, scene.pixels()});
    return p;
  }

  // Losses and their gradients by the planes of the picture.
  GradientPlanes evaluate(const PassScene& scene, const PixelPlanes& planes, const StepDesc& desc, const StepPhoto& photo) {
    const uint32_t pixels = scene.pixels();
    target_.resize(size_t{3} * pixels);
    launch(target_.size(), TargetKernel{photo.srgb, srgb_.data(), target_.data(), desc.clipped, target_.size()});
    LossFrame frame{};
    frame.view = desc.view;
    frame.prediction = srgb_.data();
    frame.target = target_.data();
    frame.weight = weight_of(desc, photo);
    frame.planes = planes;
    if (!scene.distortion) frame.planes.distortion = nullptr;
    frame.features = scene.features;
    frame.ignore = unpacked(unpacked_[0], photo.ignore, pixels, 1.f / 255.f);
    if (desc.losses[BlockLoss::ObjectMask] != 0.f) frame.object = unpacked(unpacked_[1], photo.object, pixels, 1.f / 255.f);
    if (scene.features > 3 && desc.losses[BlockLoss::MonocularNormal] != 0.f) {
      frame.normals = unpacked(unpacked_[2], photo.normals, size_t{3} * pixels, 1.f / 32767.f);
      frame.normal_confidence = unpacked(unpacked_[3], photo.confidence, pixels, 1.f / 255.f);
    }
    picture_gradient_.resize(size_t{3} * pixels);
    error_image_.resize(pixels);
    GradientPlanes in = losses_.evaluate(executor_, frame, desc.losses, picture_gradient_.data(), error_image_.data());
    launch(pixels, DisplayReverseKernel{
                       planes.features[0], picture_gradient_.data(), {desc.gain[0], desc.gain[1], desc.gain[2]}, pixels});
    for (size_t c = 0; c < 3; ++c) in.features[c] = picture_gradient_.data() + c * pixels;
    return in;
  }
  const float* weight_of(const StepDesc& desc, const StepPhoto& photo) {
    pixel_weight_.resize(photo.pixels);
    const PixelWeightKernel kernel{photo.ignore,         photo.object,  photo.specular,       photo.transparent, photo.coat,
                                   desc.specular_weight, desc.withheld, pixel_weight_.data(), photo.pixels};
    if (!kernel.needed()) return nullptr;
    launch(photo.pixels, kernel);
    return pixel_weight_.data();
  }
  template <class T>
  const float* unpacked(Array<float>& to, const T* from, size_t size, float factor) {
    if (from == nullptr) return nullptr;
    to.resize(size);
    launch(size, ScaleKernel<T>{from, to.data(), factor, size});
    return to.data();
  }

  SurfelGradients gradients() {
    for (size_t a = 0; a < kLearned; ++a) gradient_[a].resize(size_t{width_[a]} * count_);
    for (auto& values : statistics_) values.resize(count_);
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
    return out;
  }

  void descend(const StepDesc& desc, const SurfelGradients& out) {
    active_.resize(count_);
    active_before_.resize(count_);
    rarity_.resize(count_);
    distance_.resize(count_);
    launch(count_, StatisticsKernel{out.weight, out.error, out.screen_gradient, accumulator(), count_});
    const float* share_sum = tree_sum(executor_, share_sum_, share_.data(), count_);
    launch(count_, FactorKernel{out.weight, share_.data(), share_sum, value_[0].data(), desc.rarest, active_.data(),
                                rarity_.data(), distance_.data(), count_, desc.trained});
    launch(count_, CopyKernel<uint8_t, uint32_t>{active_.data(), active_before_.data(), count_});
    active_sum_ = exclusive_scan(executor_, active_scan_, active_before_.data(), active_before_.data(), count_);
    skipped_ = adam_.step(executor_, columns(desc.rates), active_.data(), {rarity_.data(), nullptr, distance_.data()},
                          steps_.data(), count_);
    launch(count_, LeastColourKernel{active_.data(), value_[4].data(), count_});
  }

  // `rates`: null for none.
  AdamColumns columns(const float* rates) {
    AdamColumns columns{};
    for (size_t a = 0; a < kAttributeCount; ++a)
      columns.column[a] = {a < kLearned && rates != nullptr ? gradient_[a].data() : nullptr,
                           m_[a].data(),
                           v_[a].data(),
                           value_[a].data(),
                           width_[a],
                           rates == nullptr ? 0.f : rates[a],
                           a < 4,
                           a == 0};
    return columns;
  }
  AccumulatorArrays accumulator() {
    return {weight_.data(), error_.data(), screen_gradient_.data(), share_.data(), seen_.data()};
  }
  SurfelArrays arrays() const {
    SurfelArrays s{};
    s.mean = value_[0].data();
    s.rotation = value_[1].data();
    s.log_scale = value_[2].data();
    s.opacity = value_[3].data();
    s.sh_dc = value_[4].data();
    s.sh_rest = value_[5].data();
    s.sh_rest_width = width_[5];
    s.count = count_;
    return s;
  }
  template <class T>
  void clear(T* values, size_t size) {
    launch(size, ClearKernel<T>{values, size});
  }
  template <class Kernel>
  void launch(size_t items, const Kernel& kernel) {
    executor_.launch(kernel, blocks_for(items, Kernel::kThreads));
  }

  Executor executor_;
  PassKernels<Executor> kernels_;
  LossBlocks<Executor> losses_;
  AdamBlocks<Executor> adam_;
  RelocateBlocks<Executor> relocate_;
  PhotoStore<Executor> photos_;
  TreeSumMemory<Executor> share_sum_;
  ScanMemory<Executor> active_scan_;
  uint32_t count_ = 0, room_ = 0;  // surfels; those that the arrays of the state have room for
  uint32_t width_[kAttributeCount] = {};
  std::array<Array<float>, kAttributeCount> value_, m_, v_;
  Array<float> weight_, error_, screen_gradient_, share_;
  Array<uint32_t> steps_, seen_;
  // Of one step.
  std::array<Array<float>, kLearned> gradient_;
  std::array<Array<float>, 3> statistics_;
  Array<uint8_t> active_;
  Array<uint32_t> active_before_, counts_;
  Array<float> rarity_, distance_, planes_, srgb_, target_, pixel_weight_, picture_gradient_, error_image_;
  std::array<Array<float>, 4> unpacked_;
  const uint32_t *active_sum_ = nullptr, *skipped_ = nullptr;
  bool unread_ = false;  // the report of the last step
};

}  // namespace vitrine::blocks
