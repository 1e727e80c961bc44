// Losses of a training step of one opaque layer as kernels for a GPU: the terms of the registry (registry.cpp) but `first_hit`
// and `perceptual`. A loss without its planes or targets has value 0 and no gradient, as on the CPU.
#pragma once

#include <algorithm>
#include <optional>
#include <string_view>

#include "core/learn/loss/blocks/picture_loss_kernels.h"
#include "core/learn/loss/blocks/target_loss_kernels.h"
#include "core/render/raster/aovs.h"
#include "core/render/raster/blocks/reverse_kernels.h"

namespace vitrine::blocks {

enum class BlockLoss : uint8_t {
  L1,
  Dssim,
  NormalConsistency,
  Distortion,
  Opacity,
  Scale,
  SpecularMask,
  TransmissionMask,
  ObjectMask,
  MonocularNormal
};
inline constexpr size_t kBlockLossCount = 10;

// The loss of that name in the registry; none: there is no kernel for it.
inline std::optional<BlockLoss> block_loss(std::string_view name) {
  constexpr std::string_view kNames[kBlockLossCount] = {
      "l1",    "dssim",         "normal_consistency", "distortion",  "opacity",
      "scale", "specular_mask", "transmission_mask",  "object_mask", "monocular_normal"};
  for (size_t i = 0; i < kBlockLossCount; ++i)
    if (kNames[i] == name) return static_cast<BlockLoss>(i);
  return std::nullopt;
}

// A value for each loss: the weights of a step (WeightSchedule::at), or the losses themselves.
template <class T>
struct PerLoss {
  T of[kBlockLossCount] = {};
  T& operator[](BlockLoss loss) { return of[static_cast<size_t>(loss)]; }
  const T& operator[](BlockLoss loss) const { return of[static_cast<size_t>(loss)]; }
};
using LossFactors = PerLoss<float>;

// A picture with its targets (LossInput, LossTargets). All pointers are of the executor's memory and stay as they are until
// values(); null: no data.
struct LossFrame {
  BlockView view;
  const float *prediction, *target, *weight;  // [3,h,w], [3,h,w], [h,w]: PicturePair
  PixelPlanes planes;                         // of the forward pass, with `features` channels
  int features;
  const float *specular, *transparent, *object, *ignore, *coat, *normals, *normal_confidence;

  uint32_t pixels() const { return static_cast<uint32_t>(view.width) * static_cast<uint32_t>(view.height); }
  // First channel of a blended feature in PixelPlanes::features.
  static constexpr size_t channel(Aov feature) {
    size_t at = 0;
    for (const AovRow& r : kAovs) {
      if (r.id == feature) break;
      at += r.feature ? static_cast<size_t>(r.width) : 0;
    }
    return at;
  }
  const float* feature(Aov a) const { return channel(a) < static_cast<size_t>(features) ? planes.features[channel(a)] : nullptr; }
};

// to[k] = the number that from[k] points to; 0 for null.
struct GatherKernel {
  static constexpr uint32_t kThreads = 32;
  using Shared = NoShared;
  using Thread = NoThread;
  const float* from[kThreads];
  float* to;

  VITRINE_HD bool has_phase(uint32_t phase, const Shared&) const { return phase < 1; }
  VITRINE_HD void run(uint32_t, Place at, Thread&, Shared&) const {
    to[at.thread] = from[at.thread] == nullptr ? 0.f : *from[at.thread];
  }
};

template <class Executor>
class LossBlocks {
 public:
  // Of the weighted sum of the losses of pixels. Overwrites the picture's gradient [3,h,w], by the displayed colours, and the
  // error image [h,w] (Training::write_error_image). Returns the gradients of the other planes, in memory of this object until
  // the next call; those of the linear colour are null, as are planes without a gradient.
  GradientPlanes evaluate(Executor& executor, const LossFrame& frame, const LossFactors& factors, float* picture_gradient,
                          float* error) {
    frame_ = frame;
    factors_ = factors;
    const uint32_t width = static_cast<uint32_t>(frame.view.width), height = static_cast<uint32_t>(frame.view.height);
    picture_.evaluate(executor, {frame.prediction, frame.target, frame.weight, width, height},
                      {factors[BlockLoss::L1], factors[BlockLoss::Dssim]}, picture_gradient, error);
    for (auto& sum : sums_.of) sum = nullptr;
    ignored_ = frame.ignore == nullptr ? nullptr : tree_sum(executor, ignore_sum_, frame.ignore, frame.pixels());
    choose_planes();
    launch(executor, planes_.size(), FillKernel{planes_.data(), 0.f, planes_.size()});
    if (on(BlockLoss::NormalConsistency)) normal_consistency(executor);
    if (on(BlockLoss::MonocularNormal)) monocular_normal(executor);
    masks(executor);
    if (on(BlockLoss::Distortion)) {
      launch(executor, frame.pixels(), FillKernel{distortion_, step_of(BlockLoss::Distortion), frame.pixels()});
      sum(executor, BlockLoss::Distortion, frame.planes.distortion, frame.pixels());
    }
    GradientPlanes out{};
    for (size_t c = 0; c < 3 && normal_.plane[0] != nullptr; ++c)
      out.features[LossFrame::channel(Aov::Normal) + c] = normal_.plane[c];
    out.features[LossFrame::channel(Aov::SpecularWeight)] = specular_weight_;
    out.features[LossFrame::channel(Aov::Transmission)] = transmission_;
    out.zdepth = zdepth_;
    out.alpha = alpha_;
    out.distortion = distortion_;
    out.error = error;
    return out;
  }

  // Adds the gradients of the losses of surfels, with the weights of the last evaluate().
  void regularise(Executor& executor, const SurfelArrays& surfels, const SurfelGradients& gradients) {
    const uint32_t n = surfels.count;
    surfels_ = n;
    if (n > 0 && factors_[BlockLoss::Opacity] != 0.f)
      activation<true>(executor, BlockLoss::Opacity, surfels.opacity, n, gradients.opacity);
    if (n > 0 && factors_[BlockLoss::Scale] != 0.f)
      activation<false>(executor, BlockLoss::Scale, surfels.log_scale, 2 * n, gradients.log_scale);
  }

  // Of the last evaluate() and regularise(). Waits for the device.
  struct Values {
    double total;           // weighted sum
    double mean_error;      // mean of |C - C_photo| over pixels and channels, without weights
    PerLoss<double> terms;  // without factors; 0: the term was off
  };
  Values values(Executor& executor) {
    const auto picture = picture_.sums(executor);
    GatherKernel gather{};
    for (size_t k = 0; k < kBlockLossCount; ++k) gather.from[k] = sums_.of[k];
    gather.from[static_cast<size_t>(BlockLoss::L1)] = picture.l1;
    gather.from[static_cast<size_t>(BlockLoss::Dssim)] = picture.dssim;
    gather.from[kPlain] = picture.plain;
    gather.from[kWeight] = picture.weight;
    gather.from[kIgnored] = ignored_;
    gathered_.resize(GatherKernel::kThreads);
    gather.to = gathered_.data();
    executor.launch(gather, 1);
    float here[GatherKernel::kThreads];
    executor.download(here, gathered_.data(), GatherKernel::kThreads);
    const double pixels = frame_.pixels(), weight = picture.weight == nullptr ? pixels : static_cast<double>(here[kWeight]);
    Values values{};
    values.mean_error = here[kPlain] / pixels;
    for (size_t k = 0; k < kBlockLossCount; ++k) {
      const BlockLoss loss = static_cast<BlockLoss>(k);
      double of = pixels;
      if (loss == BlockLoss::L1 || loss == BlockLoss::Dssim) of = 3 * weight;
      if (is_mask(loss)) of = pixels - static_cast<double>(here[kIgnored]);
      if (loss == BlockLoss::Opacity) of = surfels_;
      if (loss == BlockLoss::Scale) of = 2.0 * surfels_;
      if (of <= 0 || factors_[loss] == 0.f) continue;
      values.terms[loss] = here[k] / of;
      values.total += double{factors_[loss]} * values.terms[loss];
    }
    return values;
  }

 private:
  template <class T>
  using Array = typename Executor::template Array<T>;
  static constexpr size_t kPlain = kBlockLossCount, kWeight = kPlain + 1, kIgnored = kWeight + 1;  // places of GatherKernel

  template <class Kernel>
  static void launch(Executor& executor, size_t items, const Kernel& kernel) {
    executor.launch(kernel, blocks_for(items, Kernel::kThreads));
  }
  static bool is_mask(BlockLoss loss) {
    return loss == BlockLoss::SpecularMask || loss == BlockLoss::TransmissionMask || loss == BlockLoss::ObjectMask;
  }
  // Whether a loss of planes has a weight and its data.
  bool on(BlockLoss loss) const {
    if (factors_[loss] == 0.f) return false;
    switch (loss) {
      case BlockLoss::NormalConsistency:
        return frame_.feature(Aov::Normal) != nullptr && frame_.view.width >= 3 && frame_.view.height >= 3;
      case BlockLoss::Distortion:
        return frame_.planes.distortion != nullptr;
      case BlockLoss::SpecularMask:
        return frame_.specular != nullptr && frame_.feature(Aov::SpecularWeight) != nullptr;
      case BlockLoss::TransmissionMask:
        return frame_.transparent != nullptr && frame_.feature(Aov::Transmission) != nullptr;
      case BlockLoss::ObjectMask:
        return frame_.object != nullptr;
      case BlockLoss::MonocularNormal:
        return frame_.normals != nullptr && frame_.feature(Aov::Normal) != nullptr;
      default:
        return false;
    }
  }
  float step_of(BlockLoss loss) const { return factors_[loss] / static_cast<float>(frame_.pixels()); }

  void choose_planes() {
    const bool depth = on(BlockLoss::NormalConsistency), normal = depth || on(BlockLoss::MonocularNormal);
    const bool alpha = depth || on(BlockLoss::ObjectMask), distortion = on(BlockLoss::Distortion);
    const bool specular = on(BlockLoss::SpecularMask), transmission = on(BlockLoss::TransmissionMask);
    planes_.resize(size_t{frame_.pixels()} *
                   static_cast<size_t>(3 * normal + depth + alpha + distortion + specular + transmission));
    float* next = planes_.data();
    const auto plane = [&](bool wanted) {
      if (!wanted) return static_cast<float*>(nullptr);
      next += frame_.pixels();
      return next - frame_.pixels();
    };
    for (float*& p : normal_.plane) p = plane(normal);
    zdepth_ = plane(depth);
    alpha_ = plane(alpha);
    distortion_ = plane(distortion);
    specular_weight_ = plane(specular);
    transmission_ = plane(transmission);
  }
  // Room for the values of a loss.
  float* values_of(BlockLoss loss, uint32_t count) {
    auto& values = values_.of[static_cast<size_t>(loss)];
    values.resize(count);
    return values.data();
  }
  void sum(Executor& executor, BlockLoss loss, const float* values, uint32_t count) {
    sums_[loss] = tree_sum(executor, sum_memory_.of[static_cast<size_t>(loss)], values, count);
  }

  Planes3<const float> normals() const {
    const float* const* n = frame_.planes.features + LossFrame::channel(Aov::Normal);
    return {{n[0], n[1], n[2]}};
  }

  void normal_consistency(Executor& executor) {
    const uint32_t pixels = frame_.pixels();
    const auto& camera = frame_.view.camera;
    const DepthSurface surface{frame_.planes.zdepth,
                               frame_.planes.alpha,
                               camera.fx.v,
                               camera.fy.v,
                               camera.cx.v,
                               camera.cy.v,
                               static_cast<uint32_t>(frame_.view.width),
                               static_cast<uint32_t>(frame_.view.height)};
    slopes_.resize(size_t{6} * pixels);
    Planes3<float> down, right;
    Planes3<const float> down_in, right_in;
    for (size_t c = 0; c < 3; ++c) {
      down_in.plane[c] = down.plane[c] = slopes_.data() + c * pixels;
      right_in.plane[c] = right.plane[c] = slopes_.data() + (3 + c) * pixels;
    }
    float* const values = values_of(BlockLoss::NormalConsistency, pixels);
    launch(executor, pixels,
           NormalConsistencyKernel{surface, normals(), camera.rotation, step_of(BlockLoss::NormalConsistency), normal_, down,
                                   right, values});
    launch(executor, pixels, DepthGradientKernel{surface, down_in, right_in, zdepth_, alpha_});
    sum(executor, BlockLoss::NormalConsistency, values, pixels);
  }
  void monocular_normal(Executor& executor) {
    float* const values = values_of(BlockLoss::MonocularNormal, frame_.pixels());
    launch(
        executor, frame_.pixels(),
        TargetNormalKernel{normals(), frame_.view.camera.rotation, frame_.planes.alpha, frame_.normals, frame_.normal_confidence,
                           frame_.ignore, step_of(BlockLoss::MonocularNormal), frame_.pixels(), normal_, values});
    sum(executor, BlockLoss::MonocularNormal, values, frame_.pixels());
  }
  void masks(Executor& executor) {
    const uint32_t pixels = frame_.pixels();
    const auto run = [&](BlockLoss loss, const float* mask, const auto& kernel_of) {
      if (!on(loss)) return;
      float* const values = values_of(loss, pixels);
      launch(executor, pixels, kernel_of(MaskedPixels{mask, frame_.ignore, ignored_, factors_[loss], pixels}, values));
      sum(executor, loss, values, pixels);
    };
    run(BlockLoss::SpecularMask, frame_.specular, [&](const MaskedPixels& p, float* values) {
      return SpecularMaskKernel{p,     frame_.feature(Aov::SpecularWeight), frame_.transparent, frame_.coat, specular_weight_,
                                values};
    });
    run(BlockLoss::TransmissionMask, frame_.transparent, [&](const MaskedPixels& p, float* values) {
      return CrossEntropyKernel{p, frame_.feature(Aov::Transmission), transmission_, values};
    });
    run(BlockLoss::ObjectMask, frame_.object, [&](const MaskedPixels& p, float* values) {
      return CrossEntropyKernel{p, frame_.planes.alpha, alpha_, values};
    });
  }
  template <bool kSigmoid>
  void activation(Executor& executor, BlockLoss loss, const float* raw, uint32_t count, float* gradient) {
    float* const values = values_of(loss, count);
    launch(executor, count, ActivationKernel<kSigmoid>{raw, factors_[loss] / static_cast<float>(count), gradient, values, count});
    sum(executor, loss, values, count);
  }

  PictureLossBlocks<Executor> picture_;
  LossFrame frame_{};
  LossFactors factors_;
  uint32_t surfels_ = 0;
  PerLoss<Array<float>> values_;
  PerLoss<TreeSumMemory<Executor>> sum_memory_;
  PerLoss<const float*> sums_;  // of values over pixels or surfels; null: the loss is off
  TreeSumMemory<Executor> ignore_sum_;
  const float* ignored_ = nullptr;  // sum of the ignore mask; null: there is none
  Array<float> planes_, slopes_, gathered_;
  // In planes_; null: no gradient.
  Planes3<float> normal_{};
  float *zdepth_ = nullptr, *alpha_ = nullptr, *distortion_ = nullptr, *specular_weight_ = nullptr, *transmission_ = nullptr;
};

}  // namespace vitrine::blocks
