#include "core/model/diffuse_pass.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace vitrine {

namespace {
constexpr size_t kDiffuseGrain = 1 << 15;  // floats
}

void DiffusePass::forward(const SplatScene& scene, Frame& frame) {
  RasterDesc desc;
  desc.intrinsics = frame.view->intrinsics;
  desc.cam_from_world = frame.view->cam_from_world;
  const bool layered = scene.reflection.size() + scene.transmittance.size() > 0;
  desc.features = layered || options_.materials ? FeatureSet::Material : FeatureSet::Surface;
  desc.sh_degree = std::min(options_.sh_degree, scene.diffuse.sh_degree());
  desc.distortion = options_.distortion;
  desc.near_z = options_.near_z;
  renderer_->forward(scene.diffuse, desc, frame.diffuse);
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
  // The renderer adds to what it finds: the last picture, or what was seen through glass in this one.
  if (!frame.behind.statistics.weight.empty())
    std::swap(frame.statistics, frame.behind.statistics);
  else
    for (auto* values : {&frame.statistics.screen_gradient, &frame.statistics.weight, &frame.statistics.error})
      values->assign(scene.diffuse.size(), 0.f);
  renderer_->backward({.gradients = &frame.grad_diffuse, .error_image = frame.error_image}, grad.diffuse, &frame.statistics);
}

}  // namespace vitrine
