#include "core/model/thin_glass_pass.h"

#include <algorithm>

#include "core/base/parallel.h"
#include "core/scene/activation.h"

namespace vitrine {

namespace {

constexpr size_t kGrain = 512;        // surfels, groups
constexpr float kMostlyClear = 0.5f;  // a surfel is glass above
constexpr Attribute kShapeAndColor[] = {Attribute::Mean,    Attribute::Rotation, Attribute::LogScale,
                                        Attribute::Opacity, Attribute::ShDc,     Attribute::ShRest};

// Coefficients above the degree in use are not part of the picture, whatever the other layer's degree is.
size_t used_width(const SplatLayer& layer, Attribute a, int degree) {
  return a == Attribute::ShRest ? 3 * (sh_coefficient_count(degree) - 1) : layer.width(a);
}

}  // namespace

void ThinGlassPass::merge(const SplatScene& scene) {
  const SplatLayer& diffuse = scene.diffuse;
  opaque_.clear();
  for (size_t i = 0; i < diffuse.size(); ++i)
    if (!(sigmoid(*diffuse.at(Attribute::Transmission, i)) > kMostlyClear)) opaque_.push_back(static_cast<uint32_t>(i));
  const int of_diffuse = std::min(diffuse_sh_degree_, diffuse.sh_degree());
  const int of_layer = std::min(options_.sh_degree, scene.transmittance.sh_degree()), degree = std::max(of_diffuse, of_layer);
  const size_t count = opaque_.size() + scene.transmittance.size();
  if (behind_.kind() != LayerKind::Transmittance || behind_.sh_degree() != degree)
    behind_ = SplatLayer(LayerKind::Transmittance, degree, count);
  behind_.resize(count);
  parallel_chunks(count, kGrain, [&](size_t, size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const bool own = k >= opaque_.size();
      const SplatLayer& from = own ? scene.transmittance : diffuse;
      const size_t i = own ? k - opaque_.size() : opaque_[k];
      for (Attribute a : kShapeAndColor) {
        const size_t used = used_width(from, a, own ? of_layer : of_diffuse);
        std::fill(std::copy_n(from.at(a, i), used, behind_.at(a, k)), behind_.at(a, k) + behind_.width(a), 0.f);
      }
    }
  });
}

void ThinGlassPass::forward(const SplatScene& scene, Frame& frame) {
  SecondaryRays& r = frame.transmission;
  const ShadedPixels& s = frame.shaded;
  for (auto* values : {&frame.seen_through.screen_gradient, &frame.seen_through.weight, &frame.seen_through.error})
    values->clear();
  if (options_.glass != Glass::Thin || scene.transmittance.size() == 0) return;
  if (std::none_of(s.asks.begin(), s.asks.end(), [](const LayersPresent& asks) { return asks.transmission; })) return;
  merge(scene);
  RasterDesc desc;
  desc.intrinsics = frame.view->intrinsics;
  desc.cam_from_world = frame.view->cam_from_world;
  desc.features = FeatureSet::Surface;
  desc.sh_degree = behind_.sh_degree();
  renderer_->forward(behind_, desc, picture_);

  const size_t groups = s.groups(), pixels = frame.pixel_count();
  const std::span<const float> color = picture_.plane(Aov::Color), alpha = picture_.plane(Aov::Alpha);
  r.begin.assign(groups + 1, 0);
  for (size_t g = 0; g < groups; ++g) r.begin[g + 1] = r.begin[g] + (s.asked(g).transmission ? 1 : 0);
  r.radiance.assign(groups, Vec3f{});
  r.grad_radiance.assign(groups, Vec3f{});
  r.inner_transmittance.assign(groups, 1.f);
  r.picture_weight.assign(groups, 0.f);
  for (size_t g = 0; g < groups; ++g) {
    if (!s.asked(g).transmission) continue;
    const uint32_t p = s.chosen_pixel(g);
    r.radiance[g] = {color[p], color[pixels + p], color[2 * pixels + p]};
    r.inner_transmittance[g] = 1.f - alpha[p];
  }
}

void ThinGlassPass::backward(const SplatScene& scene, Frame& frame, SplatScene& grad) {
  SecondaryRays& r = frame.transmission;
  const ShadedPixels& s = frame.shaded;
  if (options_.glass != Glass::Thin || r.radiance.empty()) return;
  const size_t pixels = frame.pixel_count();
  gradients_.width = picture_.width;
  gradients_.height = picture_.height;
  std::vector<float>& color = gradients_.planes[static_cast<size_t>(Aov::Color)];
  color.assign(3 * pixels, 0.f);
  blame_.assign(frame.error_image.empty() ? 0 : pixels, 0.f);
  for (size_t g = 0; g < s.groups(); ++g) {
    if (!s.asked(g).transmission) continue;
    const uint32_t p = s.chosen_pixel(g);
    for (size_t c = 0; c < 3; ++c) color[c * pixels + p] = r.grad_radiance[g][c];
    if (!blame_.empty()) blame_[p] = s.weight(g) * r.picture_weight[g] * frame.error_image[p];
  }
  if (grad_.size() != behind_.size() || grad_.sh_degree() != behind_.sh_degree())
    grad_ = behind_.zeros_like();
  else
    grad_.fill(0.f);
  const auto reset = [](SurfelStatistics& statistics, size_t size) {
    for (auto* values : {&statistics.screen_gradient, &statistics.weight, &statistics.error}) values->assign(size, 0.f);
  };
  reset(statistics_, behind_.size());
  renderer_->backward({.gradients = &gradients_, .error_image = blame_}, grad_, &statistics_);

  reset(frame.seen_through, scene.diffuse.size());
  reset(r.statistics, scene.transmittance.size());
  parallel_chunks(behind_.size(), kGrain, [&](size_t, size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const bool own = k >= opaque_.size();
      SplatLayer& to = own ? grad.transmittance : grad.diffuse;
      SurfelStatistics& statistics = own ? r.statistics : frame.seen_through;
      const size_t i = own ? k - opaque_.size() : opaque_[k];
      const int degree = own ? std::min(options_.sh_degree, to.sh_degree()) : std::min(diffuse_sh_degree_, to.sh_degree());
      for (Attribute a : kShapeAndColor)
        for (size_t c = 0, used = used_width(to, a, degree); c < used; ++c) to.at(a, i)[c] += grad_.at(a, k)[c];
      statistics.screen_gradient[i] = statistics_.screen_gradient[k];
      statistics.weight[i] = statistics_.weight[k];
      statistics.error[i] = statistics_.error[k];
    }
  });
}

}  // namespace vitrine
