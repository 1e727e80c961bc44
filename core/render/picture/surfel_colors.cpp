#include "core/render/picture/surfel_colors.h"

#include <algorithm>

#include "core/render/model/opened_scene.h"
#include "core/render/model/sheet_pass.h"

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

namespace {

// The scene without glass, with its albedo. With Glass::Traced no opaque surfels are behind glass.
SurfelColors behind_glass(const SplatScene& scene, const ImageOptions& image, const DecomposedMaterials& materials) {
  SplatScene parts{.diffuse = scene.diffuse, .transmittance = scene.transmittance};
  if (image.transmission.glass != Glass::Thin) parts.diffuse.resize(0);
  OpenedScene opened;
  without_glass(parts, {}, opened);
  std::vector<Vec3f> albedo;
  for (const uint32_t i : opened.opaque) albedo.push_back(materials.albedo[i]);
  albedo.insert(albedo.end(), materials.albedo_behind_glass.begin(), materials.albedo_behind_glass.end());
  return {opened.surfels, albedo, image.diffuse.near_z};
}

}  // namespace

AlbedoPainter::AlbedoPainter(const SplatScene& scene, const ImageOptions& image, const DecomposedMaterials& materials) {
  const float near_z = image.diffuse.near_z;
  const bool sheets = draws_sheets(image);  // their surfels are not rendered
  if (materials.albedo_behind_glass.size() == scene.transmittance.size() && (sheets || scene.transmittance.size() > 0))
    behind_.emplace(behind_glass(scene, image, materials));
  if (behind_ && sheets) return;
  first_.emplace(scene.diffuse, materials.albedo, near_z);
  if (!behind_) return;
  std::vector<Vec3f> clear;
  for (const float t : materials.transmission) clear.push_back({t, t, t});
  clear_.emplace(scene.diffuse, clear, near_z);
}

ImageF AlbedoPainter::picture(const View& view) {
  if (!first_) return behind_->picture(view);
  ImageF out = first_->picture(view);
  if (!behind_) return out;
  const ImageF clear = clear_->picture(view), behind = behind_->picture(view);
  for (size_t i = 0; i < out.data().size(); ++i) out.data()[i] += clear.data()[i] * (behind.data()[i] - out.data()[i]);
  return out;
}

}  // namespace vitrine
