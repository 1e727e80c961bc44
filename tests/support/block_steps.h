// Surfels and photos for training steps as kernels (core/learn/trainer/blocks): disturbed surfels learn pictures of the
// undisturbed ones.
#pragma once

#include <algorithm>
#include <vector>

#include "core/foundation/base/rng.h"
#include "core/learn/trainer/blocks/step_pass.h"

namespace vitrine::test {

class StepScene {
 public:
  static constexpr uint32_t kWidths[kAttributeCount] = {3, 4, 2, 1, 3, 9, 0, 0, 0, 0};

  // `count` surfels in front of `views` cameras in a row, of pictures of width x height. No function of a library is used: the
  // values are the same on every machine.
  StepScene(uint32_t count, int width, int height, int views) : count_(count) {
    Rng rng(7);
    std::vector<float>&mean = values_[0], &dc = values_[4];
    for (uint32_t i = 0; i < count; ++i) {
      for (const float range : {3.f, 2.f, 1.f}) mean.push_back((rng.uniform() - 0.5f) * range);
      for (const float at : {1.f, 0.f, 0.f, 0.f}) values_[1].push_back(at + (rng.uniform() - 0.5f) * 0.6f);
      for (int c = 0; c < 2; ++c) values_[2].push_back(scale_of(count) + (rng.uniform() - 0.5f));
      values_[3].push_back(rng.uniform() * 2);
      for (int c = 0; c < 3; ++c) dc.push_back((rng.uniform() - 0.5f) * 2);
      for (int c = 0; c < 9; ++c) values_[5].push_back((rng.uniform() - 0.5f) * 0.1f);
    }
    for (int k = 0; k < views; ++k) views_.push_back(view_of(k, views, width, height));
    true_mean_ = mean;
    true_dc_ = dc;
    for (float& v : dc) v += (rng.uniform() - 0.5f) * 1.5f;
    for (float& v : mean) v += (rng.uniform() - 0.5f) * 0.01f;
    for (size_t a = 0; a < kAttributeCount; ++a) zeros_[a].resize(size_t{kWidths[a]} * count);
    ones_.assign(count, 1.f);
    sums_.resize(count);
    counts_.resize(count);
  }

  const std::vector<blocks::BlockView>& views() const { return views_; }
  // Pictures of the undisturbed surfels, then the disturbed ones are put there.
  std::vector<std::vector<uint16_t>> start(blocks::StepPass& steps) {
    steps.put(state(true));
    std::vector<std::vector<uint16_t>> photos;
    for (const blocks::BlockView& view : views_) {
      auto& photo = photos.emplace_back();
      for (const float value : steps.picture(view, {1.f, 1.f, 1.f}))
        photo.push_back(static_cast<uint16_t>(value * 65535.f + 0.5f));
    }
    steps.put(state(false));
    return photos;
  }

 private:
  static float scale_of(uint32_t count) { return count < 1000 ? -1.8f : count < 100000 ? -4.f : -4.8f; }
  static blocks::BlockView view_of(int k, int views, int width, int height) {
    using blocks::F32;
    blocks::BlockView v{};
    const float x = 0.3f * (static_cast<float>(k) - 0.5f * static_cast<float>(views - 1));
    v.camera = {F32(static_cast<float>(width)),
                F32(static_cast<float>(width)),
                F32(0.5f * static_cast<float>(width)),
                F32(0.5f * static_cast<float>(height)),
                Mat3<F32>{{F32(1.f), F32(0.f), F32(0.f)}, {F32(0.f), F32(1.f), F32(0.f)}, {F32(0.f), F32(0.f), F32(1.f)}},
                {F32(-x), F32(0.f), F32(3.f)},
                {F32(x), F32(0.f), F32(-3.f)}};
    v.near_z = 0.05f;
    v.far_z = 100;
    v.low_pass = static_cast<float>(kLowPassInvVariance);
    v.width = width;
    v.height = height;
    v.tiles_x = (width + blocks::BlockView::kTileSide - 1) / blocks::BlockView::kTileSide;
    v.tiles_y = (height + blocks::BlockView::kTileSide - 1) / blocks::BlockView::kTileSide;
    v.sh_degree = 1;
    return v;
  }
  blocks::StepState state(bool truth) {
    blocks::StepState s{};
    s.surfels = count_;
    for (size_t a = 0; a < kAttributeCount; ++a) {
      s.width[a] = kWidths[a];
      s.value[a] = truth && a == 0 ? true_mean_.data() : truth && a == 4 ? true_dc_.data() : values_[a].data();
      s.m[a] = s.v[a] = zeros_[a].data();
    }
    s.weight = s.error = s.screen_gradient = sums_.data();
    s.share = ones_.data();
    s.steps = s.seen = counts_.data();
    return s;
  }

  uint32_t count_;
  std::vector<float> values_[kAttributeCount], zeros_[kAttributeCount], true_mean_, true_dc_, ones_, sums_;
  std::vector<uint32_t> counts_;
  std::vector<blocks::BlockView> views_;
};

// Runs `count` steps through the photos in turn; `losses`: the L1 of each, for which each step waits.
inline void take_steps(blocks::StepPass& steps, const StepScene& scene, const std::vector<std::vector<uint16_t>>& photos,
                       int count, std::vector<double>* losses = nullptr) {
  for (int k = 0; k < count; ++k) {
    const uint32_t photo = static_cast<uint32_t>(k) % static_cast<uint32_t>(photos.size());
    blocks::StepDesc desc{};
    desc.view = scene.views()[photo];
    for (float& gain : desc.gain) gain = 1;
    desc.clipped = 0.98f;
    desc.specular_weight = 1;
    desc.losses[blocks::BlockLoss::L1] = 0.8f;
    desc.losses[blocks::BlockLoss::Dssim] = 0.2f;
    desc.losses[blocks::BlockLoss::NormalConsistency] = 0.05f;
    desc.losses[blocks::BlockLoss::Opacity] = desc.losses[blocks::BlockLoss::Scale] = 0.003f;
    std::copy_n(std::begin({1e-3f, 4e-3f, 1e-2f, 5e-2f, 2e-2f, 1e-3f}), 6, desc.rates);
    desc.rarest = 4;
    desc.trained = steps.surfels();
    blocks::StepPhoto picture{};
    picture.photo = photo;
    picture.pixels = static_cast<uint32_t>(desc.view.width * desc.view.height);
    picture.srgb = photos[photo].data();
    steps.step(desc, picture);
    if (losses != nullptr) losses->push_back(steps.report()->l1);
  }
}

// The values of the surfels, attribute by attribute, from the device.
inline std::vector<std::vector<float>> surfel_values(blocks::StepPass& steps) {
  const size_t n = steps.surfels();
  std::vector<std::vector<float>> values(kAttributeCount), m(kAttributeCount), v(kAttributeCount), sums(4, std::vector<float>(n));
  std::vector<uint32_t> counts[2] = {std::vector<uint32_t>(n), std::vector<uint32_t>(n)};
  blocks::StepState s{};
  for (size_t a = 0; a < kAttributeCount; ++a) {
    s.width[a] = StepScene::kWidths[a];
    for (auto* all : {&values, &m, &v}) (*all)[a].resize(n * s.width[a]);
    s.value[a] = values[a].data();
    s.m[a] = m[a].data();
    s.v[a] = v[a].data();
  }
  s.weight = sums[0].data();
  s.error = sums[1].data();
  s.screen_gradient = sums[2].data();
  s.share = sums[3].data();
  s.steps = counts[0].data();
  s.seen = counts[1].data();
  steps.get(s);
  return values;
}

}  // namespace vitrine::test
