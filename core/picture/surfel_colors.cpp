#include "core/picture/surfel_colors.h"

#include <algorithm>

namespace vitrine {

namespace {
constexpr float kTrustedAlpha = 0.5f;
}

SplatLayer painted_layer(const SplatLayer& surfels, std::span<const Vec3f> colors) {
  VITRINE_CHECK(colors.size() == surfels.size(), "{} colours for {} surfels", colors.size(), surfels.size());
  SplatLayer out(surfels.kind(), 0, surfels.size());
  for (const AttributeRow& r : kAttributes)
    if (r.id != Attribute::ShDc && r.id != Attribute::ShRest) std::ranges::copy(surfels.values(r.id), out.values(r.id).begin());
  for (size_t i = 0; i < colors.size(); ++i)
    for (size_t c = 0; c < 3; ++c) out.at(Attribute::ShDc, i)[c] = (colors[i][c] - 0.5f) / kShDc;
  return out;
}

SurfelColors::SurfelColors(const SplatLayer& layer, std::span<const Vec3f> colors, float near_z)
    : layer_(painted_layer(layer, colors)), near_z_(near_z), renderer_(make_renderer(Backend::Cpu)) {}

ImageF SurfelColors::picture(const View& view) {
  RasterDesc desc;
  desc.intrinsics = view.intrinsics;
  desc.cam_from_world = view.cam_from_world;
  desc.features = FeatureSet::ColorOnly;
  desc.sh_degree = 0;
  desc.near_z = near_z_;
  renderer_->forward(layer_, desc, images_);
  const auto color = images_.plane(Aov::Color), alpha = images_.plane(Aov::Alpha);
  ImageF out(view.intrinsics.width, view.intrinsics.height, 3);
  const size_t n = out.pixel_count();
  for (size_t i = 0; i < n; ++i)
    if (alpha[i] >= kTrustedAlpha)
      for (size_t c = 0; c < 3; ++c) out.data()[3 * i + c] = std::max(0.f, color[c * n + i]) / alpha[i];
  return out;
}

}  // namespace vitrine
