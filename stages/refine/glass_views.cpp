#include "stages/refine/glass_views.h"

#include "core/foundation/base/process.h"
#include "core/render/model/layered_model.h"
#include "core/render/model/surface_pass.h"
#include "core/render/raster/raster_desc.h"

namespace vitrine {

namespace {

constexpr float kLeastAlpha = 0.5f, kClear = 0.5f, kHardlyClear = 0.1f;  // coverage; tau; tau

}  // namespace

std::vector<GlassView> glass_views(const GlassViewsDesc& desc, std::span<const uint32_t> photos) {
  ImageModel model({.diffuse = desc.scene.image.diffuse});
  model.options().diffuse.materials = true;
  model.emplace<DiffusePass>(desc.scene.image.diffuse.backend);
  Frame frame;
  TargetImages masks;
  std::vector<GlassView> views;
  for (const uint32_t photo : photos) {
    throw_if_interrupted();
    GlassView v{.photo = photo, .view = &desc.capture.photos[photo].levels[desc.level].view};
    model.forward(desc.scene.surfels, *v.view, frame);
    const auto z = frame.diffuse.plane(Aov::ZDepth), alpha = frame.diffuse.plane(Aov::Alpha);
    const auto median = frame.diffuse.plane(Aov::MedianZ), tau = frame.diffuse.plane(Aov::Transmission);
    decode(desc.targets.photos[photo][desc.level], masks);
    const auto mask = masks.mask(MaskClass::Transparent);
    const size_t pixels = frame.pixel_count();
    v.zdepth.assign(pixels, 0.f);
    v.glass.assign(pixels, 0.f);
    v.opaque.assign(pixels, 0);
    for (size_t i = 0; i < pixels; ++i) {
      const bool marked = mask.empty() ? tau[i] > kClear * alpha[i] : mask[i] > 0.5f;
      v.glass[i] = marked && alpha[i] > kLeastAlpha ? 1.f : 0.f;
      if (!(alpha[i] > kLeastAlpha)) continue;
      v.zdepth[i] = surface_depth(z[i], alpha[i], median[i]);
      v.opaque[i] = !marked && tau[i] < kHardlyClear * alpha[i];
    }
    v.segments = glass_segments(*v.view, v.zdepth, v.glass, desc.mesh, desc.segments);
    views.push_back(std::move(v));
  }
  return views;
}

}  // namespace vitrine
