#include "core/model/diffuse_pass.h"

#include <algorithm>

#include "core/base/parallel.h"

namespace vitrine {

namespace {
constexpr size_t kDiffuseGrain = 1 << 15;  // floats
}

void DiffusePass::forward(const SplatScene& scene, Frame& frame) {
  const DiffuseOptions& options = frame.options.diffuse;
  RasterDesc desc;
  desc.intrinsics = frame.view->intrinsics;
  desc.cam_from_world = frame.view->cam_from_world;
  const bool layered = scene.reflection.size() + scene.transmittance.size() > 0;
  desc.features = layered || options.materials ? FeatureSet::Material : FeatureSet::Surface;
  desc.sh_degree = std::min(options.sh_degree, scene.diffuse.sh_degree());
  desc.distortion = options.distortion;
  desc.near_z = options.near_z;
  renderer_->forward(scene.diffuse, desc, frame.diffuse);
  const auto color = frame.diffuse.plane(Aov::Color);
  frame.linear.resize(color.size());
  parallel_chunks(color.size(), kDiffuseGrain, [&](size_t, size_t begin, size_t end) {
    std::copy(color.data() + begin, color.data() + end, frame.linear.data() + begin);
  });
  frame.grad_diffuse.reset(desc);
}

void DiffusePass::backward(const SplatScene&, Frame& frame, SplatScene& grad) {
  const auto grad_color = frame.grad_diffuse.plane(Aov::Color);
  parallel_chunks(grad_color.size(), kDiffuseGrain, [&](size_t, size_t begin, size_t end) {
    for (size_t i = begin; i < end; ++i) grad_color[i] += frame.grad_linear[i];
  });
  renderer_->backward({.gradients = &frame.grad_diffuse, .error_image = frame.error_image}, grad.diffuse, &frame.statistics);
}

}  // namespace vitrine
