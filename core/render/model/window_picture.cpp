#include "core/render/model/window_picture.h"

#include <algorithm>

namespace vitrine {

void WindowPicture::copy_chosen(const SplatLayer& layer) {
  chosen_.clear();
  for (const auto& chosen : chunks_) chosen_.insert(chosen_.end(), chosen.begin(), chosen.end());
  if (surfels_.kind() != layer.kind() || surfels_.sh_degree() != layer.sh_degree())
    surfels_ = SplatLayer(layer.kind(), layer.sh_degree(), 0);
  surfels_.resize(chosen_.size());
  parallel_chunks(chosen_.size(), kGrain, [&](size_t, size_t first, size_t last) {
    for (const AttributeRow& r : kAttributes)
      for (size_t k = first; k < last; ++k) std::copy_n(layer.at(r.id, chosen_[k]), layer.width(r.id), surfels_.at(r.id, k));
  });
}

const RasterImages& WindowPicture::draw(const Style& style) {
  RasterDesc desc;
  desc.intrinsics = window_.intrinsics;
  desc.cam_from_world = window_.cam_from_world;
  desc.features = style.features;
  desc.sh_degree = std::min(style.sh_degree, surfels_.sh_degree());
  desc.near_z = style.near_z;
  desc.wanted = style.wanted;
  renderer_->forward(surfels_, desc, picture_);
  if (style.differentiable) gradients_.reset(desc);
  return picture_;
}

void WindowPicture::backward(std::span<const float> error, SplatLayer& grad, SurfelStatistics& statistics) {
  if (grad_.size() != surfels_.size() || grad_.sh_degree() != surfels_.sh_degree())
    grad_ = surfels_.zeros_like();
  else
    grad_.fill(0.f);
  statistics_.reset(surfels_.size());
  renderer_->backward({.gradients = &gradients_, .error_image = error}, grad_, &statistics_);
  parallel_chunks(chosen_.size(), kGrain, [&](size_t, size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const size_t i = chosen_[k];
      for (const AttributeRow& r : kAttributes)
        for (size_t c = 0, n = surfels_.width(r.id); c < n; ++c) grad.at(r.id, i)[c] += grad_.at(r.id, k)[c];
      statistics.screen_gradient[i] += statistics_.screen_gradient[k];
      statistics.weight[i] += statistics_.weight[k];
      statistics.error[i] += statistics_.error[k];
    }
  });
}

}  // namespace vitrine
