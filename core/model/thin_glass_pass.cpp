#include "core/model/thin_glass_pass.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/scene/activation.h"

namespace vitrine {

namespace {

constexpr size_t kThinGrain = 512;    // surfels, groups
constexpr float kMostlyClear = 0.5f;  // a surfel is glass above
constexpr Attribute kShapeAndColor[] = {Attribute::Mean,    Attribute::Rotation, Attribute::LogScale,
                                        Attribute::Opacity, Attribute::ShDc,     Attribute::ShRest};

// Coefficients above the degree in use are not part of the picture, whatever the other layer's degree is.
size_t used_width(const SplatLayer& layer, Attribute a, int degree) {
  return a == Attribute::ShRest ? 3 * (sh_coefficient_count(degree) - 1) : layer.width(a);
}

}  // namespace

void BehindGlass::clear() {
  for (auto* plane : {&radiance, &grad_radiance, &inner_transmittance, &median_z, &picture_weight}) plane->clear();
  path.clear();
}

std::vector<uint32_t> opaque_surfels(const SplatLayer& diffuse) {
  std::vector<uint32_t> out;
  for (size_t i = 0; i < diffuse.size(); ++i)
    if (!(sigmoid(*diffuse.at(Attribute::Transmission, i)) > kMostlyClear)) out.push_back(static_cast<uint32_t>(i));
  return out;
}

void without_glass(const SplatScene& scene, int of_diffuse, int of_layer, OpenedScene& opened) {
  const SplatLayer& diffuse = scene.diffuse;
  auto& [merged, opaque] = opened;
  opaque = opaque_surfels(diffuse);
  of_diffuse = std::min(of_diffuse, diffuse.sh_degree());
  of_layer = std::min(of_layer, scene.transmittance.sh_degree());
  const int degree = std::max(of_diffuse, of_layer);
  const size_t count = opaque.size() + scene.transmittance.size();
  if (merged.kind() != LayerKind::Transmittance || merged.sh_degree() != degree)
    merged = SplatLayer(LayerKind::Transmittance, degree, count);
  merged.resize(count);
  parallel_chunks(count, kThinGrain, [&](size_t, size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const bool own = k >= opaque.size();
      const SplatLayer& from = own ? scene.transmittance : diffuse;
      const size_t i = own ? k - opaque.size() : opaque[k];
      for (Attribute a : kShapeAndColor) {
        const size_t used = used_width(from, a, own ? of_layer : of_diffuse);
        std::fill(std::copy_n(from.at(a, i), used, merged.at(a, k)), merged.at(a, k) + merged.width(a), 0.f);
      }
    }
  });
}

void ThinGlassPass::forward(const SplatScene& scene, Frame& frame) {
  const ShadedPixels& s = frame.shaded;
  BehindGlass& behind = frame.behind;
  const TransmissionOptions& options = frame.options.transmission;
  behind.clear();
  if (options.glass != Glass::Thin || scene.transmittance.size() == 0) return;
  wanted_.assign(frame.pixel_count(), 0);
  for (size_t i = 0; i < s.pixels.size(); ++i) wanted_[s.pixels[i]] = s.asks[i].transmission;
  if (std::ranges::find(wanted_, 1) == wanted_.end()) return;
  without_glass(scene, frame.options.diffuse.sh_degree, options.sh_degree, frame.opened);
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
  behind.picture_weight.assign(alpha.size(), 0.f);
  if (options.thick) bent_.forward(options, merged, frame);
}

void ThinGlassPass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  BehindGlass& behind = frame.behind;
  if (behind.radiance.empty()) return;
  const TransmissionOptions& options = frame.options.transmission;
  const auto& [merged, opaque] = frame.opened;
  blame_.resize(frame.error_image.size());
  for (size_t i = 0; i < blame_.size(); ++i) blame_[i] = behind.picture_weight[i] * frame.error_image[i];
  if (grad_.size() != merged.size() || grad_.sh_degree() != merged.sh_degree())
    grad_ = merged.zeros_like();
  else
    grad_.fill(0.f);
  statistics_.reset(merged.size());
  if (options.thick) bent_.backward(frame, blame_, grad_, statistics_);
  gradients_.width = picture_.width;
  gradients_.height = picture_.height;
  std::swap(gradients_.planes[static_cast<size_t>(Aov::Color)], behind.grad_radiance);
  renderer_->backward({.gradients = &gradients_, .error_image = blame_}, grad_, &statistics_);

  SurfelStatistics& of_layer = frame.transmission.statistics;
  of_layer.reset(scene.transmittance.size());
  parallel_chunks(merged.size(), kThinGrain, [&](size_t, size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const bool own = k >= opaque.size();
      SplatLayer& to = own ? grad.transmittance : grad.diffuse;
      SurfelStatistics& statistics = own ? of_layer : frame.statistics;
      const size_t i = own ? k - opaque.size() : opaque[k];
      const int degree = std::min(own ? options.sh_degree : frame.options.diffuse.sh_degree, to.sh_degree());
      for (Attribute a : kShapeAndColor)
        for (size_t c = 0, used = used_width(to, a, degree); c < used; ++c) to.at(a, i)[c] += grad_.at(a, k)[c];
      statistics.screen_gradient[i] += statistics_.screen_gradient[k];
      statistics.weight[i] += statistics_.weight[k];
      statistics.error[i] += statistics_.error[k];
    }
  });
}

}  // namespace vitrine
