// Surfels and photos for training steps as kernels (core/learn/trainer/blocks): disturbed surfels learn pictures of the
// undisturbed ones, which the renderer "blocks" made.
#pragma once

#include <algorithm>
#include <vector>

#include "core/foundation/base/rng.h"
#include "core/learn/trainer/blocks/step_blocks.h"

namespace vitrine::test {

class StepScene {
 public:
  // `count` surfels in front of `views` cameras in a row, of pictures of width x height. No function of a library is used: the
  // values are the same on every machine.
  StepScene(uint32_t count, int width, int height, int views) : count_(count) {
    Rng rng(7);
    for (uint32_t i = 0; i < count; ++i) {
      for (const float range : {3.f, 2.f, 1.f}) mean_.push_back((rng.uniform() - 0.5f) * range);
      for (const float at : {1.f, 0.f, 0.f, 0.f}) rotation_.push_back(at + (rng.uniform() - 0.5f) * 0.6f);
      for (int c = 0; c < 2; ++c) log_scale_.push_back(scale_of(count) + (rng.uniform() - 0.5f));
      opacity_.push_back(rng.uniform() * 2);
      for (int c = 0; c < 3; ++c) sh_dc_.push_back((rng.uniform() - 0.5f) * 2);
      for (int c = 0; c < 9; ++c) sh_rest_.push_back((rng.uniform() - 0.5f) * 0.1f);
    }
    for (int k = 0; k < views; ++k) views_.push_back(view_of(k, views, width, height));
    disturbed_dc_ = sh_dc_;
    disturbed_mean_ = mean_;
    for (float& v : disturbed_dc_) v += (rng.uniform() - 0.5f) * 1.5f;
    for (float& v : disturbed_mean_) v += (rng.uniform() - 0.5f) * 0.01f;
  }

  blocks::SurfelArrays truth() const { return arrays(mean_, sh_dc_); }
  blocks::SurfelArrays start() const { return arrays(disturbed_mean_, disturbed_dc_); }
  const std::vector<blocks::BlockView>& views() const { return views_; }

  // Display-referred pictures of the truth.
  template <class Executor>
  std::vector<float> photo(Executor executor, const blocks::BlockView& view) const {
    blocks::StepBlocks<Executor> renderer(executor, truth(), count_);
    return renderer.picture({view, {1.f, 1.f, 1.f}, 0});
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
  blocks::SurfelArrays arrays(const std::vector<float>& mean, const std::vector<float>& dc) const {
    blocks::SurfelArrays s{};
    s.mean = mean.data();
    s.rotation = rotation_.data();
    s.log_scale = log_scale_.data();
    s.opacity = opacity_.data();
    s.sh_dc = dc.data();
    s.sh_rest = sh_rest_.data();
    s.sh_rest_width = 9;
    s.count = count_;
    return s;
  }

  uint32_t count_;
  std::vector<float> mean_, rotation_, log_scale_, opacity_, sh_dc_, sh_rest_, disturbed_mean_, disturbed_dc_;
  std::vector<blocks::BlockView> views_;
};

inline constexpr std::array<float, 6> kStepRates{1e-3f, 4e-3f, 1e-2f, 5e-2f, 2e-2f, 1e-3f};

// Runs `count` steps through the photos in turn; `losses`: the L1 of each, for which each step waits.
template <class Steps, class Photos>
void take_steps(Steps& steps, const Photos& photos, int count, std::vector<double>* losses = nullptr) {
  for (int k = 0; k < count; ++k) {
    steps.step(photos[static_cast<size_t>(k) % photos.size()], kStepRates, {0.8f, 0.2f});
    if (losses != nullptr) losses->push_back(steps.losses().l1);
  }
}

template <class Executor>
std::vector<blocks::StepPhoto> add_photos(blocks::StepBlocks<Executor>& steps, const StepScene& scene, const Executor& executor) {
  std::vector<blocks::StepPhoto> photos;
  for (const blocks::BlockView& view : scene.views())
    photos.push_back({view, {1.f, 1.f, 1.f}, steps.add_photo(scene.photo(executor, view))});
  return photos;
}

}  // namespace vitrine::test
