#include "core/render/model/diffuse_pass.h"

#include <algorithm>

#include "core/foundation/base/parallel.h"
#include "core/render/model/opened_scene.h"
#include "core/render/model/sheet_pass.h"

namespace vitrine {

namespace {
constexpr size_t kDiffuseGrain = 1 << 15;  // floats per parallel chunk
}

void DiffusePass::forward(const SplatScene& scene, Frame& frame) {
  const DiffuseOptions& options = frame.options.diffuse;
  RasterDesc desc;
  desc.intrinsics = frame.view->intrinsics;
  desc.cam_from_world = frame.view->cam_from_world;
  opened_ = draws_sheets(frame.options);
  const bool layered = scene.reflection.size() + scene.transmittance.size() > 0 || opened_;
  desc.features = layered || options.materials ? FeatureSet::Material : FeatureSet::Surface;
  frame.opened.clear();
  if (opened_) without_glass_with_materials(scene, opened_degrees(scene, frame.options), frame.opened);
  const SplatLayer& drawn = opened_ ? frame.opened.surfels : scene.diffuse;
  desc.sh_degree = opened_ ? drawn.sh_degree() : std::min(options.sh_degree, drawn.sh_degree());
  desc.distortion = options.distortion;
  desc.near_z = options.near_z;
  renderer_->forward(drawn, desc, frame.diffuse);
  const auto color = frame.diffuse.plane(Aov::Color);
  frame.linear.resize(color.size());
  parallel_chunks(color.size(), kDiffuseGrain, [&](size_t, size_t begin, size_t end) {
    std::copy(color.data() + begin, color.data() + end, frame.linear.data() + begin);
  });
  frame.grad_diffuse.reset(desc);
}

void DiffusePass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  const auto grad_color = frame.grad_diffuse.plane(Aov::Color);
  parallel_chunks(grad_color.size(), kDiffuseGrain, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) grad_color[i] += frame.grad_linear[i];
  });
  if (opened_) return backward_of_opened(scene, frame, grad);
  renderer_->backward({.gradients = &frame.grad_diffuse, .error_image = frame.error_image}, grad.diffuse, &frame.statistics);
}

void DiffusePass::backward_of_opened(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  const SplatLayer& drawn = frame.opened.surfels;
  if (grad_.size() != drawn.size() || grad_.sh_degree() != drawn.sh_degree())
    grad_ = drawn.zeros_like();
  else
    grad_.fill(0.f);
  statistics_.reset(drawn.size());
  renderer_->backward({.gradients = &frame.grad_diffuse, .error_image = frame.error_image}, grad_, &statistics_);
  give_back(opened_degrees(scene, frame.options), {grad_, statistics_}, frame, grad);
}

}  // namespace vitrine
