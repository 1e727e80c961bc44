#include "core/render/model/thin_glass_pass.h"

#include <algorithm>

#include "core/render/model/opened_scene.h"

namespace vitrine {

void BehindGlass::clear() {
  for (auto* plane : {&radiance, &grad_radiance, &inner_transmittance, &median_z}) plane->clear();
  path.clear();
}

// Behind known thin glass, uses the picture of the scene without glass.
void ThinGlassPass::take_drawn(Frame& frame) const {
  BehindGlass& behind = frame.behind;
  const auto color = frame.diffuse.plane(Aov::Color);
  behind.radiance.assign(color.begin(), color.end());
  behind.grad_radiance.assign(color.size(), 0.f);
  behind.median_z = frame.sheets.behind_median;
  behind.inner_transmittance.resize(frame.pixel_count());
  std::ranges::transform(frame.sheets.behind_alpha, behind.inner_transmittance.begin(), [](float a) { return 1.f - a; });
}

void ThinGlassPass::forward(const SplatScene& scene, Frame& frame) {
  const ShadedPixels& s = frame.shaded;
  BehindGlass& behind = frame.behind;
  const TransmissionOptions& options = frame.options.transmission;
  behind.clear();
  const bool sheets = !frame.sheets.empty();
  if (options.glass != Glass::Thin || (scene.transmittance.size() == 0 && !sheets)) return;
  wanted_.assign(frame.pixel_count(), 0);
  for (size_t i = 0; i < s.pixels.size(); ++i) wanted_[s.pixels[i]] = s.requests[i].transmission;
  if (std::ranges::find(wanted_, 1) == wanted_.end()) return;
  drawn_ = sheets;
  if (drawn_)
    take_drawn(frame);
  else
    draw(scene, frame);
  if (options.thick) bent_.forward(options, frame.opened.surfels, frame);
}

// With known thin glass the diffuse pass has already rendered it.
void ThinGlassPass::draw(const SplatScene& scene, Frame& frame) {
  BehindGlass& behind = frame.behind;
  without_glass(scene, opened_degrees(scene, frame.options), frame.opened);
  const SplatLayer& merged = frame.opened.surfels;
  RasterDesc desc;
  desc.intrinsics = frame.view->intrinsics;
  desc.cam_from_world = frame.view->cam_from_world;
  desc.features = FeatureSet::Surface;
  desc.near_z = frame.options.diffuse.near_z;
  desc.sh_degree = merged.sh_degree();
  desc.wanted = wanted_;
  renderer_->forward(merged, desc, picture_);
  const std::span<const float> color = picture_.plane(Aov::Color), alpha = picture_.plane(Aov::Alpha);
  behind.radiance.assign(color.begin(), color.end());
  behind.grad_radiance.assign(color.size(), 0.f);
  behind.inner_transmittance.resize(alpha.size());
  std::transform(alpha.begin(), alpha.end(), behind.inner_transmittance.begin(), [](float a) { return 1.f - a; });
  const std::span<const float> median = picture_.plane(Aov::MedianZ);
  behind.median_z.assign(median.begin(), median.end());
}

void ThinGlassPass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  BehindGlass& behind = frame.behind;
  if (behind.radiance.empty()) return;
  const TransmissionOptions& options = frame.options.transmission;
  const auto straight = [&] {
    const auto color = frame.grad_diffuse.plane(Aov::Color);
    for (size_t i = 0; i < color.size(); ++i) color[i] += behind.grad_radiance[i];
  };
  if (drawn_ && !(options.thick && bent_.any())) return straight();
  const SplatLayer& merged = frame.opened.surfels;
  error_image_.resize(frame.error_image.size());
  for (size_t i = 0; i < error_image_.size(); ++i) error_image_[i] = behind.picture_weight[i] * frame.error_image[i];
  if (grad_.kind() != merged.kind() || grad_.size() != merged.size() || grad_.sh_degree() != merged.sh_degree())
    grad_ = merged.zeros_like();
  else
    grad_.fill(0.f);
  statistics_.reset(merged.size());
  if (options.thick) bent_.backward(frame, error_image_, grad_, statistics_);
  if (drawn_) {
    straight();
    give_back(opened_degrees(scene, frame.options), {grad_, statistics_}, frame, grad);
    return;
  }
  gradients_.width = picture_.width;
  gradients_.height = picture_.height;
  std::vector<float>& of_color = gradients_.planes[static_cast<size_t>(Aov::Color)];
  std::swap(of_color, behind.grad_radiance);
  renderer_->backward({.gradients = &gradients_, .error_image = error_image_}, grad_, &statistics_);
  std::swap(of_color, behind.grad_radiance);
  give_back(opened_degrees(scene, frame.options), {grad_, statistics_}, frame, grad);
}

}  // namespace vitrine
